#pragma once
// Compressed tables in a file: their parts one after the other, each at a multiple of 64 bytes.
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "core/reduction/atlas/compressed_table.hpp"
#include "core/reduction/atlas/packed_table.hpp"

namespace flexopt {

inline std::uint64_t padded(std::uint64_t size) { return (size + 63) / 64 * 64; }

/// Adds `count` numbers to a block whose size is a multiple of 64.
template <class T>
void append_part(std::string& block, const T* data, std::uint64_t count) {
  if (count == 0) return;
  const std::size_t at = block.size();
  block.resize(at + padded(count * sizeof(T)), '\0');
  std::memcpy(block.data() + at, data, count * sizeof(T));
}

/// Reads the parts of a block one after the other.
struct PartReader {
  const char* data;
  std::uint64_t size, at = 0;
  bool whole = true;  ///< whether all that was read was there

  /// The next `count` numbers; null beyond the end.
  template <class T>
  const T* next(std::uint64_t count) {
    if (count > size / sizeof(T) || at > size - count * sizeof(T)) return nullptr;
    const T* part = reinterpret_cast<const T*>(data + at);
    at += padded(count * sizeof(T));
    return part;
  }
  /// Points `part` to the next `count` numbers.
  template <class T>
  void read(const T*& part, std::uint64_t count) {
    part = next<T>(count);
    whole = whole && part;
  }
};

void append_table(std::string& block, const CompressedTable& table);
void append_table(std::string& block, const PackedTable& table);
/// Fills in the numbers of a table whose counts are known. False where they are not whole, or the
/// counts are none.
bool read_table(PartReader& reader, CompressedTable& table);
bool read_table(PartReader& reader, PackedTable& table);

}  // namespace flexopt
