#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/spec/record_table.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

enum class Kind { plate, beam };

struct Part {
  int degree = 5;
};

struct Leaf {
  double length = 0;
  int count = 3;
  Kind kind = Kind::beam;
  std::optional<double> limit;
  std::array<int, 2> mesh{10, 4};
  std::string note;
  Part part;
  double half = 0;
};

RecordTable<Leaf> leaf_table() {
  return RecordTable<Leaf>()
      .required("length", shape::quantity("m", 0, 20, true), &Leaf::length, "length of the leaf")
      .with_default("count", shape::integer(1, 9), &Leaf::count, "how many")
      .choice<Kind>("kind", {{"plate", Kind::plate}, {"beam", Kind::beam}}, &Leaf::kind, "model")
      .optional("limit", shape::quantity("Pa"), &Leaf::limit, "largest stress")
      .with_default("mesh", shape::list(shape::integer(1, 99), 2, 2), &Leaf::mesh, "elements")
      .optional("note", shape::text(), &Leaf::note, "words")
      .with_default(
          "degree", shape::integer(1, 9), [](auto& leaf) -> auto& { return leaf.part.degree; },
          "of its part")
      .row(
          shape::optional("twice", shape::quantity("1"), "two halves"),
          [](const json& read, Leaf& leaf) { leaf.half = read.get<double>() / 2; },
          [](const Leaf& leaf) { return leaf.half == 0 ? json() : json(2 * leaf.half); })
      .other(shape::optional("later", shape::quantity("1"), "read by code"));
}

}  // namespace

TEST_CASE("a row brings its value to the member, in SI") {
  const RecordTable<Leaf> table = leaf_table();
  const json read = read_value(
      table.shape(), json::parse(R"({"length": "80 mm", "count": 4, "kind": "plate", "limit":
      "2 MPa", "mesh": [6, 2], "note": "thin", "degree": 7, "twice": 3, "later": 1})"));
  const Leaf leaf = table.read(read);
  CHECK(leaf.length == 0.08);
  CHECK(leaf.count == 4);
  CHECK(leaf.kind == Kind::plate);
  CHECK(leaf.limit == 2e6);
  CHECK(leaf.mesh == std::array{6, 2});
  CHECK(leaf.note == "thin");
  CHECK(leaf.part.degree == 7);
  CHECK(leaf.half == 1.5);
  json written = table.write(leaf);
  CHECK_FALSE(written.contains("later"));
  written["later"] = 1;
  CHECK(written == read);
}

TEST_CASE("the default of a row is what a new record holds") {
  const RecordTable<Leaf> table = leaf_table();
  const json read = read_value(table.shape(), {{"length", 1}});
  CHECK(read == json::parse(R"({"length": 1.0, "count": 3, "kind": "beam", "mesh": [10, 4],
                                "degree": 5})"));
  CHECK(table.write(table.read(read)) == read);
  CHECK(json_schema(table.shape())["properties"]["kind"]["default"] == "beam");
  CHECK(json_schema(table.shape())["properties"]["kind"]["enum"] == json({"plate", "beam"}));
}

TEST_CASE("keys that are left out keep their members") {
  Leaf leaf;
  leaf.limit = 5;
  leaf.count = 8;
  leaf_table().read({{"length", 2}}, leaf);
  CHECK(leaf.length == 2);
  CHECK(leaf.limit == 5);
  CHECK(leaf.count == 8);
}

TEST_CASE("rows refuse what they do not allow") {
  const Shape shape = leaf_table().shape();
  CHECK_THROWS_WITH(read_value(shape, {{"length", 1}, {"kind", "plat"}}),
                    Contains("did you mean 'plate'"));
  CHECK_THROWS_WITH(read_value(shape, {{"length", 1}, {"mesh", {1, 100}}}), Contains("/mesh/1"));
  CHECK_THROWS_WITH(read_value(shape, json::object()), Contains("/length = nothing"));
}
