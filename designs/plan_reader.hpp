#pragma once
// Private to design_reader.cpp and its companions design_items.cpp, elastic_reader.cpp.
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "designs/describe.hpp"
#include "designs/design_reader.hpp"
#include "designs/elastic_item.hpp"

namespace flexopt {

class PlanReader {
 public:
  PlanReader(const nlohmann::json& document, DesignSource source, FaultList& faults,
             std::vector<std::string> within)
      : faults_(faults), within_(std::move(within)) {
    plan_.source = std::move(source);
    read_ = read_value(design_file_shape(), document, nlohmann::json::json_pointer(), faults_);
  }

  std::shared_ptr<const DesignPlan> read();

 private:
  void read_head();
  void read_parameters();
  void read_parameter(const std::string& name, const nlohmann::json& from,
                      const nlohmann::json::json_pointer& at);
  void read_options();
  void read_lets();
  void read_rules();
  void read_frames();
  void read_bodies();
  /// `of_body`: the body that the elastic body at `at` is.
  void read_elastic(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                    const nlohmann::json& of_body, BodyItem& body);
  void read_interfaces(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                       const nlohmann::json& of_body, ElasticItem& elastic, BodyItem& body);
  ElasticItem::Interface interface(const nlohmann::json& from,
                                   const nlohmann::json::json_pointer& at, std::string key,
                                   const ElasticItem& elastic, BodyItem& body);
  ElasticItem::Imported imported(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                                 bool mesh);
  void complete_interfaces(const ElasticItem::Imported& file,
                           const nlohmann::json::json_pointer& at, ElasticItem& elastic);
  /// Out of a face: "x+" at the key `face`, or a vector "normal".
  DesignVector normal_of(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                         const char* face);
  ElasticItem::Contour contour(const nlohmann::json& from, const nlohmann::json::json_pointer& at);
  ElasticItem::Plate plate(const nlohmann::json& from, const nlohmann::json::json_pointer& at);
  ElasticItem::Notch notch(const nlohmann::json& from, const nlohmann::json::json_pointer& at);
  void read_leaves();
  HeldPlace edge(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                 LeafItem& leaf);
  void read_joints();
  void read_springs();
  void read_parts();
  void read_drives();
  void read_actuator(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                     DriveItem& drive);
  /// `at`: pointer of the direction, which ends with `key` behind that of the body.
  HeldDirection held(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                     std::string key);
  PartItem part(const nlohmann::json& from, const nlohmann::json::json_pointer& at);
  std::shared_ptr<const DesignPlan> plan_of_part(const nlohmann::json& from,
                                                 const nlohmann::json::json_pointer& at);

  /// All valid records of a list.
  template <class Read>
  void each(const char* list, Read read);
  void read_item(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                 const char* kind, DesignItem& item);
  void read_repeat(const nlohmann::json& from, const nlohmann::json::json_pointer& at,
                   DesignItem& item);
  /// The name of an item or of what it refers to. Numbers in braces are compiled into `item`.
  std::string name(const std::string& text, const nlohmann::json::json_pointer& at,
                   DesignItem& item);
  ChoiceCondition condition(const std::string& text, const nlohmann::json::json_pointer& at);

  /// Reads a number, which may use the names known to the present item.
  DesignNumber number(const nlohmann::json& from, const std::string& unit,
                      const nlohmann::json::json_pointer& at);
  DesignVector vector(const nlohmann::json& from, const std::string& unit,
                      const nlohmann::json::json_pointer& at);
  DesignPoint point(const nlohmann::json& from, const std::string& unit,
                    const nlohmann::json::json_pointer& at);
  DesignMatrix matrix(const nlohmann::json& from, const std::string& unit,
                      const nlohmann::json::json_pointer& at);
  DesignSize size(const nlohmann::json& from, const nlohmann::json::json_pointer& at);
  void check_name(const std::string& name, const nlohmann::json::json_pointer& at);
  /// A formula of these names; of one with a name whose own entry is faulty no fault is told.
  Formula formula(std::string text, const std::vector<FormulaName>& names,
                  const nlohmann::json::json_pointer& at);
  /// The formula, whose names count as used.
  std::shared_ptr<const Formula> used(Formula formula);

  FaultList& faults_;
  std::vector<std::string> within_;
  nlohmann::json read_;
  DesignPlan plan_;
  std::vector<FormulaName> names_;  ///< names of parameters and lets; then of the item's indices
  std::set<std::string> used_;      ///< those of them that formulas use
  std::set<std::string> lost_;      ///< names of parameters and lets that have faults themselves
};

template <class Read>
void PlanReader::each(const char* list, Read read) {
  const std::vector<FormulaName> names = names_;
  for (std::size_t i = 0; i < read_[list].size(); ++i) {
    const nlohmann::json::json_pointer at =
        nlohmann::json::json_pointer("/" + std::string(list)) / i;
    const nlohmann::json& from = read_[list][i];
    if (!from.is_object() || !faults_.sound(at)) continue;
    faults_.attempt([&] { read(from, at); });
    names_ = names;
  }
}

}  // namespace flexopt
