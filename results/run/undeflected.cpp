#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/spec/spec_error.hpp"
#include "results/files/result_json.hpp"
#include "results/run/run.hpp"

namespace flexopt {

RunRecord undeflected(const Job& job) {
  if (!job.designs.empty())
    throw SpecError("/designs", fmt::format("{} designs", job.designs.size()),
                    "a job of one design can be shown");
  RunRecord record;
  record.job = job;
  record.mechanism = make_mechanism(job, job.design.parameters);
  PathPoint point;
  for (const auto& leaf : make_full_leaves(record.mechanism, job.model))
    point.shapes.push_back(leaf->shape());
  point.bodies.resize(record.mechanism.bodies.size());
  record.response.path = {point};
  record.cases.assign(job.cases.size(), record.response);
  record.status = "undeflected";
  record.message = "The mechanism as designed; no equilibrium was computed.";
  return record;
}

OrderedJson undeflected_result(const RunRecord& record) {
  OrderedJson result = make_result(record);
  for (const char* key : {"case", "cases", "extremes"}) result.erase(key);
  result["status"] = record.status;
  result["message"] = record.message;
  result["path"] = OrderedJson::array();
  return result;
}

}  // namespace flexopt
