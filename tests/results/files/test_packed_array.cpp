#include <zlib.h>

#include "results/files/scene.hpp"
#include "tests/results/results_tests.hpp"

namespace {

/// The bytes of a packed array, by a decoder of its own.
std::string bytes_of(const OrderedJson& array) {
  const std::string text = array["data"].get<std::string>();
  std::string packed;
  unsigned group = 0;
  int letters = 0, pads = 0;
  const auto digit = [](char c) -> unsigned {
    if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(c - 'A');
    if (c >= 'a' && c <= 'z') return static_cast<unsigned>(c - 'a' + 26);
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0' + 52);
    return c == '+' ? 62u : 63u;
  };
  for (const char c : text) {
    if (c == '=') ++pads;
    group = group << 6 | (c == '=' ? 0u : digit(c));
    if (++letters % 4 == 0) {
      for (int k = 0; k < 3 - pads; ++k) packed += static_cast<char>(group >> (16 - 8 * k) & 255);
      group = 0;
    }
  }
  std::string bytes(1 << 20, '\0');
  uLongf size = bytes.size();
  REQUIRE(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                     reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK);
  bytes.resize(size);
  return bytes;
}

}  // namespace

TEST_CASE("base64 is that of RFC 4648") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64(std::string("\xff\xfe\x00", 3)) == "//4A");
}

TEST_CASE("Packed numbers come back bit by bit") {
  std::vector<float> values;
  for (int k = 0; k < 1000; ++k) values.push_back(0.37f * static_cast<float>(k * k) - 5e-4f);
  const OrderedJson array = packed_floats(values, {250, 4});
  CHECK(array["type"] == "float32");
  CHECK(array["shape"] == OrderedJson({250, 4}));
  const std::string bytes = bytes_of(array);
  REQUIRE(bytes.size() == 4000);
  for (std::size_t i = 0; i < 1000; ++i) {
    std::uint32_t word = 0;
    for (std::size_t b = 0; b < 4; ++b)
      word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[1000 * b + i])) << 8 * b;
    float back;
    std::memcpy(&back, &word, 4);
    CHECK(back == values[i]);
  }
}

TEST_CASE("Packed rows are differences of rows, also where those overflow") {
  const std::vector<std::int16_t> values{1, -2, 32767, 7, -32768, -32768};
  const OrderedJson array = packed_rows(values, {3, 2});
  CHECK(array["type"] == "int16");
  const std::string bytes = bytes_of(array);
  REQUIRE(bytes.size() == 12);
  std::vector<std::int16_t> back;
  for (std::size_t i = 0; i < 6; ++i) {
    const unsigned word = static_cast<unsigned char>(bytes[i]) |
                          static_cast<unsigned>(static_cast<unsigned char>(bytes[6 + i])) << 8;
    const int before = i < 2 ? 0 : back[i - 2];
    back.push_back(static_cast<std::int16_t>(static_cast<std::uint16_t>(word + before)));
  }
  CHECK(back == values);
}
