#pragma once
// What a leaf answers when it is asked for something that not every model can do.
#include <memory>
#include <string>

namespace flexopt {

/// What was asked for, or nothing and the reason.
template <class T>
struct Answer {
  std::unique_ptr<T> value;
  std::string reason = {};  ///< why there is none; empty if there is one
};

}  // namespace flexopt
