#pragma once
// Numbers of VTU files.
#include <catch2/catch.hpp>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace flexopt::test {

/// The array whose name begins so.
inline std::vector<double> data_array(const std::string& xml, const std::string& name) {
  const auto at = xml.find("Name=\"" + name);
  REQUIRE(at != std::string::npos);
  const auto begin = xml.find('>', at) + 1;
  std::istringstream stream(xml.substr(begin, xml.find('<', begin) - begin));
  return {std::istream_iterator<double>(stream), {}};
}

}  // namespace flexopt::test
