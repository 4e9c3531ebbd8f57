#include <fmt/format.h>

#include <chrono>
#include <mutex>

#include "core/reduction/atlas/atlas_file.hpp"
#include "core/reduction/atlas/make_atlas.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/solvers/parallel.hpp"
#include "results/cli/command_line.hpp"
#include "results/run/progress.hpp"

namespace flexopt {
namespace {

void print_check(const AtlasCheck& check) {
  fmt::print("against tubes built anew, {} random shapes a ray:\n",
             check.cells[0] * check.cells[1]);
  struct Column {
    const char* name;
    double AtlasCheck::Errors::*error;
  };
  using Errors = AtlasCheck::Errors;
  constexpr std::array<Column, 5> columns{{{"drive load", &Errors::drive},
                                           {"stiffness", &Errors::on_ray},
                                           {"off the ray", &Errors::off_ray},
                                           {"frequencies", &Errors::frequency},
                                           {"stress", &Errors::stress}}};
  std::string names = fmt::format("  {:>6}", "ray"), kinds = fmt::format("  {:>6}", "rho");
  for (const Column& column : columns) {
    names += fmt::format(" {:>21}", column.name);
    kinds += fmt::format(" {:>10} {:>10}", "median", "largest");
  }
  fmt::print("{}\n{}\n", names, kinds);
  for (const AtlasCheck::Ray& ray : check.rays) {
    const Errors median = ray.median(), largest = ray.largest();
    fmt::print("  {:>6.2f}", ray.rho);
    for (const Column& column : columns)
      fmt::print(" {:>10.1e} {:>10.1e}", median.*column.error, largest.*column.error);
    fmt::print("\n");
  }
  fmt::print("largest error of the stiffness on all rays, by w/L (down) and L/t (across):\n{:>14}",
             "");
  // the middles of the cells, of the first ray's samples
  const int across = check.cells[1];
  const auto sample = [&](int cell) -> const AtlasCheck::Sample& {
    return check.rays.front().samples[cell];
  };
  for (int j = 0; j < across; ++j)
    fmt::print(" {:>10}", fmt::format("~{:.0f}", 1 / sample(j).thickness));
  fmt::print("\n");
  for (int i = 0; i < check.cells[0]; ++i) {
    fmt::print("  {:>12}", fmt::format("~{:.2f}", sample(i * across).width));
    for (int j = 0; j < across; ++j) {
      double worst = 0;
      for (const AtlasCheck::Ray& ray : check.rays)
        worst = std::max(worst, ray.samples[i * across + j].errors.on_ray);
      fmt::print(" {:>10.1e}", worst);
    }
    fmt::print("\n");
  }
}

int show_atlas(const std::string& name, const TubeAtlas& atlas) {
  const AtlasSettings& s = atlas.settings();
  fmt::print(
      "{}\n  {} x {} elements, w/L {:g} to {:g}, t/L 1/{:.0f} to 1/{:.0f}, Poisson's ratio "
      "{:g} to {:g}, to {:g} rad; contents {}\n",
      name, s.mesh[0], s.mesh[1], s.width[0], s.width[1], 1 / s.thickness[0], 1 / s.thickness[1],
      s.poissons_ratios.front(), s.poissons_ratios.back(), s.sigmas.back(), atlas.fingerprint());
  if (!atlas.check().rays.empty()) print_check(atlas.check());
  return exit_usable;
}

}  // namespace

int make_atlas_file(const CommandLine& line) {
  AtlasSettings settings;
  if (line.mesh) settings.mesh = *line.mesh;
  const bool shipped = line.file.empty() && takes_shipped_atlas(settings.mesh);
  if (line.show && shipped) return show_atlas("the atlas that comes along", *shipped_atlas());
  if (shipped)
    throw SpecError("--out", "",
                    "an atlas of this mesh comes along; with --out FILE another one is made, which "
                    "jobs take when FLEXOPT_ATLAS names it");
  const std::filesystem::path file =
      line.file.empty() ? default_atlas_file(settings.mesh) : std::filesystem::path(line.file);
  if (line.show) {
    const auto opened = open_atlas(file);
    if (opened) return show_atlas(file.string(), **opened);
    put(stderr, fmt::format("flexopt: {}: {}\n", file.string(), opened.error()));
    return exit_not_usable;
  }
  if (const Check writable = can_be_written(file); !writable)
    throw SpecError("--out", file.string(), writable.error());
  const auto begin = std::chrono::steady_clock::now();
  ProgressDisplay progress(stderr, progress_style(stderr, line.quiet));
  std::mutex mutex;
  int shown = 0;  // leaves may be told of in another order than they were done
  AtlasOptions options;
  options.loop = [&](int count, const std::function<void(int)>& work) {
    parallel_for(count, line.threads, work);
  };
  options.progress = [&](int done, int total) {
    const std::lock_guard lock(mutex);
    if (done <= shown) return;
    shown = done;
    progress.step({.done = done,
                   .total = total,
                   .what = "leaves",
                   .text = fmt::format("{} of {} leaves", done, total)});
  };
  const auto made = make_atlas(settings, options);
  if (!made) {
    put(stderr, fmt::format("flexopt: no atlas: {}\n", made.error()));
    return exit_not_usable;
  }
  if (const Check written = write_atlas(**made, file); !written)
    throw SpecError("--out", file.string(), written.error());
  print_check((*made)->check());
  fmt::print("atlas: {} ({:.1f} MB, {} leaves, {:.0f} s)\n", file.string(),
             1e-6 * static_cast<double>(std::filesystem::file_size(file)),
             shape_grid(settings).size() * static_cast<int>(settings.rays.size()),
             seconds_since(begin));
  return exit_usable;
}

}  // namespace flexopt
