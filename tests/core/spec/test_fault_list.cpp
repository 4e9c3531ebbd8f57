#include <catch2/catch.hpp>

#include "core/spec/fault_list.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

TEST_CASE("a place has one fault, and so has all that is in it") {
  FaultList faults;
  faults.add("/a/b", "1", "first");
  faults.add("/a/b", "1", "second");
  faults.add("/a/b/c", "2", "in it");
  faults.add("/a", "3", "around it");
  faults.add("/ab", "4", "beside it");
  REQUIRE(faults.faults().size() == 3);
  CHECK(faults.faults()[0].rule == "first");
  CHECK(faults.faults()[1].pointer == "/a");
  CHECK(faults.faults()[2].pointer == "/ab");
}

TEST_CASE("a value is sound if nothing is wrong with it, in it or around it") {
  FaultList faults;
  faults.add("/a/b", "1", "rule");
  CHECK_FALSE(faults.sound(""));
  CHECK_FALSE(faults.sound("/a"));
  CHECK_FALSE(faults.sound("/a/b"));
  CHECK_FALSE(faults.sound("/a/b/c"));
  CHECK(faults.sound("/a/bc"));
  CHECK(faults.sound("/a/c"));
  CHECK(faults.sound("/b"));
  faults.spoil("/b/c");
  CHECK_FALSE(faults.sound("/b"));
  faults.add("/b/c", "nothing", "a consequence");
  CHECK(faults.faults().size() == 1);
}

TEST_CASE("an unknown key leaves what is around it sound") {
  FaultList faults;
  faults.add({.pointer = "/a/colour", .value = "1", .rule = "unknown key", .of_key = true});
  CHECK(faults.sound("/a"));
  CHECK(faults.faults().size() == 1);
}

TEST_CASE("an attempt says whether it went well and keeps what was wrong") {
  FaultList faults;
  CHECK(faults.attempt([] {}));
  CHECK_NOTHROW(faults.raise());
  CHECK_FALSE(faults.attempt([] { throw SpecError("/a", "1", "rule"); }));
  CHECK_THROWS_WITH(faults.raise(), "/a = 1; rule");
}

TEST_CASE("a message has a line for each of 50 faults and the number of the rest") {
  FaultList faults;
  for (int i = 0; i < 53; ++i) faults.add("/" + std::to_string(i), "1", "rule");
  const SpecError error(faults.faults());
  const std::string text = error.what();
  CHECK(std::count(text.begin(), text.end(), '\n') == 50);
  CHECK_THAT(text, StartsWith("/0 = 1; rule\n/1 = 1; rule\n") && Contains("\n... and 3 more"));
  CHECK(error.faults().size() == 53);
  CHECK(error.pointer() == "/0");
}

TEST_CASE("a fault's text begins with file, line and column where they are known") {
  Fault fault{.pointer = "/a", .value = "1", .rule = "rule"};
  CHECK(fault.text() == "/a = 1; rule");
  fault.source = "--set";
  CHECK(fault.text() == "--set: /a = 1; rule");
  fault.source = "job.json";
  fault.line = 3;
  fault.column = 14;
  CHECK(fault.text() == "job.json:3:14: /a = 1; rule");
}
