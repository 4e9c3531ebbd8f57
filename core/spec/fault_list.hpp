#pragma once
// The faults of an input while it is read: collected, so that all are reported at once.
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/spec/spec_error.hpp"

namespace flexopt {

/// Faults in the order in which they were found, at most one a place. Later checks ask `sound`
/// before they use a value, so that one fault does not bring others as its consequence.
class FaultList {
 public:
  /// Takes a fault in, unless its place, or a place around it, has one already.
  void add(Fault fault);
  void add(std::string pointer, std::string value, std::string rule);
  void add(const JsonPointer& pointer, std::string value, std::string rule);
  void add(const SpecError& error);

  /// Runs `action`; true if it ended well, else the faults of its SpecError are taken in.
  bool attempt(const std::function<void()>& action);

  /// Attempts `read(item, pointer)` with every item of a JSON list at `at` that is sound.
  template <class List, class Pointer, class Read>
  void each(List& list, const Pointer& at, const Read& read) {
    for (std::size_t i = 0; i < list.size(); ++i)
      if (const Pointer here = at / i; sound(here)) attempt([&] { read(list[i], here); });
  }

  /// Marks a place as not to be relied upon, because of a fault elsewhere (its key is misspelt,
  /// say): no fault is reported there.
  void spoil(const std::string& pointer);
  void spoil(const JsonPointer& pointer);

  /// Whether the value at this place can be used: nothing is wrong with it, with its parts, or with
  /// what holds it. Keys that are merely unknown do no harm.
  bool sound(const std::string& pointer) const;
  bool sound(const JsonPointer& pointer) const;

  const std::vector<Fault>& faults() const { return faults_; }

  /// Throws SpecError with all faults, if there are any.
  void raise() const;

 private:
  std::vector<Fault> faults_;
  std::set<std::string> known_;    ///< places about which no more is said
  std::set<std::string> unsound_;  ///< places whose values cannot be used
};

}  // namespace flexopt
