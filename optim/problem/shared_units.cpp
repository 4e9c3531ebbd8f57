#include "optim/problem/shared_units.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <mutex>

#include "optim/problem/evaluation_log.hpp"

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

SharedUnits::SharedUnits(Sharing& sharing, const Job& job, const std::filesystem::path& log,
                         const std::string& version)
    : sharing_(sharing) {
  if (log.empty()) return;
  log_.open(log, log_identity(job, version), false, [this](const std::string& line) {
    json j = json::parse(line);
    known_[{j.at(0).get<std::string>(), j.at(1).get<int>()}] = std::move(j.at(2));
  });
}

bool SharedUnits::run(const std::string& loop, int count, int threads, const LoopProgress& progress,
                      const std::function<OrderedJson(int)>& work,
                      const std::function<void(int, const json&)>& keep) {
  std::vector<int> open;
  int done = 0;
  const std::vector<int> own = sharing_.own(loop.substr(0, loop.rfind(' ')), count);
  const auto total = static_cast<int>(own.size());
  for (const int unit : own) {
    const auto known = known_.find({loop, unit});
    if (known == known_.end()) {
      open.push_back(unit);
      continue;
    }
    keep(unit, known->second);
    ++done;
  }
  if (progress && done > 0) progress(done, total);
  std::mutex mutex;
  sharing_.run(
      open, threads,
      [&](int unit) {
        return log_line(OrderedJson::array({loop, unit, work(unit)}));
      },
      [&](int unit, const std::string& line) {
        log_.append(line);
        const json yield = json::parse(line).at(2);
        const std::lock_guard lock(mutex);
        keep(unit, yield);
        if (progress) progress(++done, total);
      });
  return sharing_.complete();
}

std::string loop_name(const std::string& name, const std::string& depends_on) {
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  for (const unsigned char c : depends_on) hash = (hash ^ c) * 1099511628211U;
  return fmt::format("{} {:016x}", name, hash);
}

}  // namespace flexopt
