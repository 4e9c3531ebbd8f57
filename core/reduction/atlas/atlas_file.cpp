#include "core/reduction/atlas/atlas_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/math/polynomial.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
#include "core/reduction/atlas/ray_interpolation.hpp"
#include "core/spec/draft.hpp"

namespace flexopt {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// Head of the file. A text of JSON and the deflated parts follow.
struct Head {
  char magic[16];
  std::uint64_t byte_order;
  std::uint64_t text_size, size;
  std::uint64_t contents;  ///< hash of all that follows the head
};
constexpr char magic[16] = "flexopt atlas 6";
constexpr std::uint64_t byte_order = 0x0102030405060708;

// Hash of 32-byte blocks, the last one filled up with zeros, by four sums that do not depend on one
// another.
std::uint64_t hash(std::string_view data) {
  constexpr std::uint64_t factor = 0xD6E8FEB86659FD93;
  const auto add = [&](std::uint64_t& h, std::uint64_t word) {
    h = (h ^ word) * factor;
    h ^= h >> 32;
  };
  std::array<std::uint64_t, 4> h{};
  for (std::size_t l = 0; l < h.size(); ++l) h[l] = 0x9E3779B97F4A7C15 + l;
  for (std::size_t i = 0; i < data.size(); i += sizeof h) {
    std::array<std::uint64_t, 4> words{};
    std::memcpy(words.data(), data.data() + i, std::min(sizeof words, data.size() - i));
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
  for (const int term : atlas_terms(0.06)) {
    const double a = stored[static_cast<std::size_t>(term)],
                 b = now[static_cast<std::size_t>(term)];
    if (!(std::abs(a - b) <= rounding * (std::abs(b) + 1e-6))) return false;
  }
  const auto terms = static_cast<std::size_t>(monomial_count(6, atlas_degree));
  for (std::size_t k = terms; k < now.size(); ++k)  // of dynamics and strains
    if (!(std::abs(stored[k] - now[k]) <= 1e-5 * std::abs(now[k]) + 1e-9)) return false;
  return true;
}

// The parts of an atlas one after the other: of each kind of tables that there is what they share,
// then the tables; then the patterns of stress.
std::vector<AtlasPart> parts_of(const TubeAtlas& atlas) {
  std::vector<AtlasPart> parts;
  const auto add = [&](const CodedTables* tables) {
    if (!tables) return;
    parts.push_back(tables->common());
    parts.insert(parts.end(), tables->tables().begin(), tables->tables().end());
  };
  add(atlas.tables().potentials.get());
  add(atlas.tables().dynamics.get());
  add(atlas.tables().stations.get());
  if (atlas.stress()) {
    add(&atlas.stress()->tables());
    parts.push_back(pack(*atlas.stress()->patterns()));
  }
  return parts;
}

// Takes the parts in the same order; throws std::out_of_range where there are not enough.
std::shared_ptr<const TubeAtlas> atlas_of(const AtlasSettings& s, const json& text,
                                          const std::string& fingerprint,
                                          const std::vector<AtlasPart>& parts) {
  std::size_t next = 0;
  const auto tables = [&](ShapeGrid grid, std::vector<int> counts, std::size_t rays) {
    const AtlasPart& common = parts.at(next++);
    std::vector<AtlasPart> own;
    for (std::size_t k = 0; k < rays * s.sigmas.size(); ++k) own.push_back(parts.at(next++));
    return std::make_shared<CodedTables>(std::move(grid), std::move(counts), common,
                                         std::move(own));
  };
  const auto alike = [&](int count) { return std::vector<int>(s.sigmas.size(), count); };
  std::vector<int> terms;
  for (const double sigma : s.sigmas) terms.push_back(static_cast<int>(atlas_terms(sigma).size()));
  TubeAtlas::Tables found;
  found.potentials = tables(shape_grid(s), terms, s.rays.size());
  if (s.dynamics) {
    found.dynamics =
        tables(shape_grid(s), alike(static_cast<int>(dynamics_form().numbers())), s.rays.size());
    found.stations = tables(shape_grid(s), alike(text.at("stations").get<int>()), s.rays.size());
  }
  std::shared_ptr<const StressAtlas> stress;
  if (s.stress_patterns > 0) {
    const StressAtlasSettings of = stress_settings(s);
    const auto patterns = unpack_patterns(of, parts.back());
    stress = std::make_shared<StressAtlas>(
        of, patterns, tables(of.grid, stress_counts(of, patterns->all()), of.rays.size()));
  }
  return std::make_shared<TubeAtlas>(s, std::move(found), check_of(text.at("check")), fingerprint,
                                     std::move(stress));
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
  json places = json::array();
  std::string deflated;
  for (const AtlasPart& part : parts_of(atlas)) {
    const std::string bytes = part.deflated();
    places.push_back({bytes.size(), part.size()});
    deflated += bytes;
  }
  json description{{"settings", settings_json(atlas.settings())},
                   {"check", check_json(atlas.check())},
                   {"parts", std::move(places)},
                   {"probe", probe()}};
  if (atlas.tables().stations) description["stations"] = atlas.tables().stations->counts().front();
  const std::string text = description.dump();
  Head head{};
  std::memcpy(head.magic, magic, sizeof magic);
  head.byte_order = byte_order;
  head.text_size = text.size();
  head.size = sizeof head + text.size() + deflated.size();
  head.contents = hash(text + deflated);
  if (Check writable = can_be_written(file); !writable) return writable;
  if (const int error = write_whole(
          file, std::string(reinterpret_cast<const char*>(&head), sizeof head) + text + deflated))
    return Because(fmt::format("{} cannot be written: {}", file.string(), std::strerror(error)));
  return {};
}

namespace {

// The atlas of the contents of a file, which `owner` keeps. `trusted`: they are not damaged, and of
// the mechanics of this program.
Answer<std::shared_ptr<const TubeAtlas>> read_atlas(std::string_view file,
                                                    const std::shared_ptr<const void>& owner,
                                                    bool trusted) {
  Head head;
  std::memcpy(&head, file.data(), sizeof head);
  if (std::memcmp(head.magic, magic, sizeof magic - 2) != 0) return Because("it is no atlas");
  const Because other_format("it is an atlas of another format");
  if (std::memcmp(head.magic, magic, sizeof magic) != 0 || head.byte_order != byte_order)
    return other_format;
  if (head.size != file.size()) return Because("it is not whole");
  const std::string_view contents = file.substr(sizeof head);
  if (head.text_size > contents.size() || (!trusted && head.contents != hash(contents)))
    return Because("its contents are damaged");
  const json text = json::parse(contents.substr(0, head.text_size), nullptr, false);
  try {
    const AtlasSettings settings = settings_of(text.at("settings"));
    if (!sound(settings) || text.at("settings").at("degree") != atlas_degree) return other_format;
    if (!trusted && !same_mechanics(text.at("probe")))
      return Because("it was made with other mechanics: this program expands leaves otherwise");
    std::vector<AtlasPart> parts;
    std::size_t at = head.text_size;
    for (const json& part : text.at("parts")) {
      const auto deflated = part.at(0).get<std::size_t>();
      if (deflated > contents.size() - at) return other_format;
      parts.emplace_back(contents.substr(at, deflated), part.at(1).get<std::size_t>(), owner);
      at += deflated;
    }
    return atlas_of(settings, text, fmt::format("{:016x}", head.contents), parts);
  } catch (const json::exception&) {
    return other_format;
  } catch (const std::out_of_range&) {
    return other_format;
  }
}

}  // namespace

Answer<std::shared_ptr<const TubeAtlas>> open_atlas(const fs::path& file) {
  auto mapping = std::make_shared<Mapping>();
  if (Check mapped = map_file(file, *mapping); !mapped) return Because(mapped.error());
  return read_atlas({mapping->data, mapping->size}, mapping, false);
}

std::string_view embedded_atlas(std::string_view name);  // written by CMake

std::shared_ptr<const TubeAtlas> shipped_atlas() {
  static const auto opened = read_atlas(embedded_atlas("atlas"), nullptr, true);
  assert(opened);
  return *opened;
}

bool takes_shipped_atlas(const std::array<int, 2>& mesh) {
  const char* named = std::getenv("FLEXOPT_ATLAS");
  return mesh == default_mesh && (!named || !*named);
}

}  // namespace flexopt
