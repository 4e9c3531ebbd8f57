// Prints the words of the schemas as a dictionary of libFuzzer.
#include <cstdio>

#include "tests/fuzz/mutations.hpp"

int main() {
  for (const std::string& word : flexopt::fuzz::dictionary()) {
    std::printf("\"");
    for (const char c : word)
      if (c < ' ' || c == '"' || c == '\\' || static_cast<unsigned char>(c) > 126)
        std::printf("\\x%02x", static_cast<unsigned char>(c));
      else
        std::printf("%c", c);
    std::printf("\"\n");
  }
  return 0;
}
