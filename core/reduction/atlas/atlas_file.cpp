#include "core/reduction/atlas/atlas_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/reduction/atlas/table_parts.hpp"
#include "core/spec/draft.hpp"

namespace flexopt {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// Head of the file. The settings as JSON, the numbers of the potentials, the compressed tables one
// after the other and the block of the stress atlas follow, each part at a multiple of 64 bytes.
struct Head {
  char magic[16];
  std::uint64_t byte_order;
  std::uint64_t text, text_size, potentials, tables, stress, stress_size, size;
  std::uint64_t contents;  ///< hash of all that follows the head
};
constexpr char magic[16] = "flexopt atlas 5";
constexpr std::uint64_t byte_order = 0x0102030405060708;

// Hash of whole 32-byte blocks, by four sums that do not depend on one another.
std::uint64_t hash(const char* data, std::uint64_t size) {
  constexpr std::uint64_t factor = 0xD6E8FEB86659FD93;
  const auto add = [&](std::uint64_t& h, std::uint64_t word) {
    h = (h ^ word) * factor;
    h ^= h >> 32;
  };
  std::array<std::uint64_t, 4> h{};
  for (std::size_t l = 0; l < h.size(); ++l) h[l] = 0x9E3779B97F4A7C15 + l;
  for (std::uint64_t i = 0; i + sizeof h <= size; i += sizeof h) {
    std::array<std::uint64_t, 4> words;
    std::memcpy(words.data(), data + i, sizeof words);
    for (std::size_t l = 0; l < h.size(); ++l) add(h[l], words[l]);
  }
  for (std::size_t l = 1; l < h.size(); ++l) add(h[0], h[l]);
  return h[0];
}

template <class Settings, class Visit>
void each_setting(Settings& s, const Visit& visit) {
  visit("mesh", s.mesh);
  visit("free_edge_torsion", s.free_edge_torsion);
  visit("width", s.width);
  visit("thickness", s.thickness);
  visit("points", s.points);
  visit("poissons_ratios", s.poissons_ratios);
  visit("rays", s.rays);
  visit("sigmas", s.sigmas);
  visit("dynamics", s.dynamics);
  visit("stress_patterns", s.stress_patterns);
  visit("stress_samples", s.stress_samples);
}

json settings_json(const AtlasSettings& s) {
  json j;
  j["degree"] = atlas_degree;
  each_setting(s, [&](const char* name, const auto& value) { j[name] = value; });
  return j;
}

AtlasSettings settings_of(const json& j) {
  AtlasSettings s;
  each_setting(s, [&](const char* name, auto& value) { j.at(name).get_to(value); });
  return s;
}

json check_json(const AtlasCheck& check) {
  json rays = json::array();
  for (const AtlasCheck::Ray& ray : check.rays) {
    json samples = json::array();
    for (const AtlasCheck::Sample& s : ray.samples)
      samples.push_back({s.width, s.thickness, s.poissons_ratio, s.errors.drive, s.errors.on_ray,
                         s.errors.off_ray, s.errors.frequency, s.errors.stress});
    rays.push_back({{"rho", ray.rho}, {"samples", samples}});
  }
  return {{"cells", check.cells}, {"rays", rays}};
}

AtlasCheck check_of(const json& j) {
  AtlasCheck check;
  j.at("cells").get_to(check.cells);
  for (const json& ray : j.at("rays")) {
    AtlasCheck::Ray& r = check.rays.emplace_back();
    ray.at("rho").get_to(r.rho);
    for (const json& s : ray.at("samples"))
      r.samples.push_back(
          {s.at(0), s.at(1), s.at(2), {s.at(3), s.at(4), s.at(5), s.at(6), s.at(7)}});
  }
  return check;
}

// Tells other mechanics: coefficients of a coarse leaf, about a bent state off every symmetry.
const std::vector<double>& probe() {
  static const std::vector<double> numbers = [] {
    const PlateShape shape{0.7, 1.0 / 90, 0.28, {4, 2}, true};
    constexpr double rho = 0.4;
    const BentStates states = bent_states(shape, {1, rho}, ray_directions(rho), {0, 0.06},
                                          {.dynamics = true, .stress = true});
    if (states.nodes.size() != 2) return std::vector<double>();
    std::vector<double> all = states.nodes[1].W;
    const StateTable &dynamics = states.dynamics[1].table, &strains = states.stress[1];
    const double largest = strains.even.col(0).cwiseAbs().maxCoeff();
    for (const VectorXd& some : {VectorXd(dynamics.even.col(0)), VectorXd(dynamics.odd.col(0)),
                                 VectorXd(strains.even.col(0) / largest)})
      all.insert(all.end(), some.begin(), some.end());
    return all;
  }();
  return numbers;
}

bool same_mechanics(const std::vector<double>& stored) {
  constexpr double rounding = 1e-7;
  const std::vector<double>& now = probe();
  if (now.empty() || stored.size() != now.size()) return false;
  for (const AtlasTerm& term : atlas_terms({0.06})) {
    const double a = stored[static_cast<std::size_t>(term.monomial)],
                 b = now[static_cast<std::size_t>(term.monomial)];
    if (!(std::abs(a - b) <= rounding * (std::abs(b) + 1e-6))) return false;
  }
  const auto terms = static_cast<std::size_t>(monomial_count(6, atlas_degree));
  for (std::size_t k = terms; k < now.size(); ++k)  // of dynamics and strains
    if (!(std::abs(stored[k] - now[k]) <= 1e-5 * std::abs(now[k]) + 1e-9)) return false;
  return true;
}

json directory(const std::vector<CompressedTable>& tables) {
  json all = json::array();
  for (const CompressedTable& t : tables) all.push_back({t.all, t.numbers, t.directions, t.shapes});
  return all;
}

// Reads the next tables of a file; false where they are incomplete.
bool read_tables(const json& entries, PartReader& reader, std::vector<CompressedTable>& tables) {
  for (const json& entry : entries) {
    CompressedTable& t = tables.emplace_back();
    t.all = entry.at(0);
    t.numbers = entry.at(1);
    t.directions = entry.at(2);
    t.shapes = entry.at(3);
    if (!read_table(reader, t)) return false;
  }
  return true;
}

// Exponents, values, values of the highest degree and their units, in this order.
template <class Numbers, class Part>
void each_potential_part(const AtlasSettings& s, Numbers& numbers, const Part& part) {
  const std::vector<AtlasTerm> terms = atlas_terms(s.sigmas);
  const auto [lower, highest] = term_counts(terms);
  const std::uint64_t rays = s.rays.size(), leaves = static_cast<std::uint64_t>(s.tables()) *
                                                     static_cast<std::uint64_t>(s.shapes());
  part(numbers.exponents, 2 * terms.size() * rays);
  part(numbers.values, leaves * static_cast<std::uint64_t>(TubeAtlas::stride(lower)));
  part(numbers.highest, leaves * static_cast<std::uint64_t>(TubeAtlas::stride(highest)));
  part(numbers.units, static_cast<std::uint64_t>(highest) * rays);
}

// Reads the potentials of a file; false where they are incomplete.
bool read_potentials(const AtlasSettings& settings, PartReader& reader,
                     TubeAtlas::Numbers& numbers) {
  each_potential_part(settings, numbers,
                      [&](const auto*& part, std::uint64_t count) { reader.read(part, count); });
  return reader.whole;
}

struct Mapping {
  const char* data = nullptr;
  std::uint64_t size = 0;
  Mapping() = default;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (data) ::munmap(const_cast<char*>(data), size);
  }
};

Check map_file(const fs::path& file, Mapping& mapping) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Because(std::strerror(errno));
  struct stat status {};
  Check mapped;
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    mapped = Because("it is no file");
  } else if (static_cast<std::uint64_t>(status.st_size) < sizeof(Head)) {
    mapped = Because("it is no atlas, or not whole");
  } else {
    void* data = ::mmap(nullptr, static_cast<std::size_t>(status.st_size), PROT_READ, MAP_SHARED,
                        descriptor, 0);
    if (data == MAP_FAILED) {
      mapped = Because(std::strerror(errno));
    } else {
      mapping.data = static_cast<const char*>(data);
      mapping.size = static_cast<std::uint64_t>(status.st_size);
    }
  }
  ::close(descriptor);
  return mapped;
}

bool sound(const AtlasSettings& s) {
  const auto ascending = [](const std::vector<double>& x) {
    return std::adjacent_find(x.begin(), x.end(), std::greater_equal<>()) == x.end();
  };
  return s.points[0] >= 2 && s.points[1] >= 2 && 0 < s.width[0] && s.width[0] < s.width[1] &&
         0 < s.thickness[0] && s.thickness[0] < s.thickness[1] && !s.poissons_ratios.empty() &&
         ascending(s.poissons_ratios) && s.rays.size() >= 2 && s.rays.front() == -1 &&
         s.rays.back() == 1 && ascending(s.rays) && s.sigmas.size() >= 2 && s.sigmas[0] == 0 &&
         ascending(s.sigmas);
}

}  // namespace

fs::path default_atlas_file(const std::array<int, 2>& mesh) {
  const auto named = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (const fs::path file = named("FLEXOPT_ATLAS"); !file.empty()) return file;
  fs::path cache = named("XDG_CACHE_HOME");
  if (cache.empty()) cache = named("HOME") / ".cache";
  return cache / "flexopt" / fmt::format("tubes-{}x{}.atlas", mesh[0], mesh[1]);
}

Check can_be_written(const fs::path& file) {
  std::error_code failed;
  if (fs::is_directory(file, failed)) return Because("it is a folder");
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), failed);
  if (failed) return Because(failed.message());
  if (const int error = try_writing(file))
    return Because(fmt::format("it cannot be written: {}", std::strerror(error)));
  return {};
}

Check write_atlas(const TubeAtlas& atlas, const fs::path& file) {
  const AtlasSettings& s = atlas.settings();
  const std::string text = json{
      {"settings", settings_json(s)},
      {"check", check_json(atlas.check())},
      {"dynamics", directory(atlas.numbers().dynamics)},
      {"stations", directory(atlas.numbers().stations)},
      {"probe", probe()}}.dump();
  Head head{};
  std::memcpy(head.magic, magic, sizeof magic);
  head.byte_order = byte_order;
  std::string contents(padded(sizeof head), '\0');
  head.text = contents.size();
  head.text_size = text.size();
  append_part(contents, text.data(), text.size());
  head.potentials = contents.size();
  each_potential_part(s, atlas.numbers(), [&](const auto* part, std::uint64_t count) {
    append_part(contents, part, count);
  });
  head.tables = contents.size();
  for (const auto* some : {&atlas.numbers().dynamics, &atlas.numbers().stations})
    for (const CompressedTable& table : *some) append_table(contents, table);
  head.stress = contents.size();
  const std::string stress = atlas.stress() ? atlas.stress()->pack() : std::string();
  head.stress_size = stress.size();
  append_part(contents, stress.data(), stress.size());
  head.size = contents.size();
  head.contents = hash(contents.data() + head.text, head.size - head.text);
  std::memcpy(contents.data(), &head, sizeof head);

  if (Check writable = can_be_written(file); !writable) return writable;
  if (const int error = write_whole(file, contents))
    return Because(fmt::format("{} cannot be written: {}", file.string(), std::strerror(error)));
  return {};
}

Answer<std::shared_ptr<const TubeAtlas>> open_atlas(const fs::path& file) {
  auto mapping = std::make_shared<Mapping>();
  if (Check mapped = map_file(file, *mapping); !mapped) return Because(mapped.error());
  Head head;
  std::memcpy(&head, mapping->data, sizeof head);
  if (std::memcmp(head.magic, magic, sizeof magic - 2) != 0) return Because("it is no atlas");
  if (std::memcmp(head.magic, magic, sizeof magic) != 0 || head.byte_order != byte_order)
    return Because("it is an atlas of another format");
  if (head.size != mapping->size) return Because("it is not whole");
  if (head.text != padded(sizeof head) ||
      head.contents != hash(mapping->data + head.text, head.size - head.text))
    return Because("its contents are damaged");
  const json text = json::parse(mapping->data + head.text,
                                mapping->data + head.text + head.text_size, nullptr, false);
  try {
    const AtlasSettings settings = settings_of(text.at("settings"));
    if (!sound(settings) || text.at("settings").at("degree") != atlas_degree ||
        head.potentials > head.tables || head.tables > head.stress ||
        head.stress + head.stress_size > head.size)
      return Because("it is an atlas of another format");
    if (!same_mechanics(text.at("probe")))
      return Because("it was made with other mechanics: this program expands leaves otherwise");
    TubeAtlas::Numbers numbers{.owner = mapping};
    PartReader potentials{mapping->data, head.tables, head.potentials};
    PartReader tables{mapping->data, head.stress, head.tables};
    if (!read_potentials(settings, potentials, numbers) ||
        !read_tables(text.at("dynamics"), tables, numbers.dynamics) ||
        !read_tables(text.at("stations"), tables, numbers.stations) ||
        (settings.dynamics && (numbers.dynamics.size() != settings.rays.size() ||
                               numbers.stations.size() != settings.rays.size())))
      return Because("it is an atlas of another format");
    std::shared_ptr<const StressAtlas> stress;
    if (settings.stress_patterns > 0) {
      stress = StressAtlas::unpack(stress_settings(settings), mapping->data + head.stress,
                                   head.stress_size, mapping);
      if (!stress) return Because("it is an atlas of another format");
    }
    return std::make_shared<TubeAtlas>(settings, numbers, check_of(text.at("check")),
                                       fmt::format("{:016x}", head.contents), std::move(stress));
  } catch (const json::exception&) {
    return Because("it is an atlas of another format");
  }
}

}  // namespace flexopt
