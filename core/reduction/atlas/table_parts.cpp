#include "core/reduction/atlas/table_parts.hpp"

namespace flexopt {
namespace {

std::uint64_t count(int n) { return static_cast<std::uint64_t>(n); }

// The parts in their order.
template <class Table, class Part>
void each_part(Table& table, const Part& part) {
  const std::uint64_t numbers = count(table.numbers), directions = count(table.directions),
                      rows = count(direction_block * CompressedTable::blocks(table.numbers));
  part(table.places, numbers);
  if constexpr (std::is_same_v<std::remove_const_t<Table>, CompressedTable>) {
    part(table.exponents, 2 * numbers);
    part(table.sizes, numbers);
    part(table.basis, rows * directions);
  } else {
    part(table.sizes, 2 * numbers);
    part(table.coarse, rows * count(table.coarse_directions()));
    part(table.fine, rows * count(table.fine_directions()));
  }
  part(table.coordinates.units, directions);
  part(table.coordinates.numbers, directions * count(table.shapes));
}

template <class Table>
void append(std::string& block, const Table& table) {
  each_part(table, [&](const auto* part, std::uint64_t n) { append_part(block, part, n); });
}

template <class Table>
bool read(PartReader& reader, Table& table) {
  if (table.numbers < 0 || table.numbers > table.all || table.directions < 1 || table.shapes < 1)
    return false;
  each_part(table, [&](const auto*& part, std::uint64_t n) { reader.read(part, n); });
  return reader.whole;
}

}  // namespace

void append_table(std::string& block, const CompressedTable& table) { append(block, table); }
void append_table(std::string& block, const PackedTable& table) { append(block, table); }
bool read_table(PartReader& reader, CompressedTable& table) { return read(reader, table); }
bool read_table(PartReader& reader, PackedTable& table) { return read(reader, table); }

}  // namespace flexopt
