#include <nlohmann/json.hpp>

#include "results/files/timings.hpp"

#include "results/files/folder.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

void write_timings(const std::filesystem::path& folder,
                   const std::map<std::string, double>& seconds) {
  write_file(folder / "timings.json", json_text({{"unit", "s"}, {"seconds", seconds}}));
}

}  // namespace flexopt
