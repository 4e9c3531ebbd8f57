#include <nlohmann/json.hpp>

#include "optim/problem/evaluation_book.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

// CBOR: each double with all its bits
std::string bytes_of(const json& value) {
  std::string bytes;
  json::to_cbor(value, bytes);
  return bytes;
}

std::string packed(const DesignValues& values) {
  json gradient = json::array();
  for (Eigen::Index i = 0; i < values.gradient.rows(); ++i) {
    const VectorXd row = values.gradient.row(i);
    gradient.push_back(std::vector<double>(row.data(), row.data() + row.size()));
  }
  return bytes_of({values.ok, values.message, values.reason,
                   values.reached ? json(*values.reached) : json(), values.goals,
                   std::move(gradient), values.no_gradient, values.of_reduced_leaves});
}

DesignValues unpacked(const std::string& bytes) {
  const json j = json::from_cbor(bytes);
  DesignValues values;
  j.at(0).get_to(values.ok);
  j.at(1).get_to(values.message);
  j.at(2).get_to(values.reason);
  if (!j.at(3).is_null()) values.reached = j.at(3).get<double>();
  j.at(4).get_to(values.goals);
  const auto rows = j.at(5).get<std::vector<std::vector<double>>>();
  if (!rows.empty())
    values.gradient.resize(static_cast<Eigen::Index>(rows.size()),
                           static_cast<Eigen::Index>(rows.front().size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < rows[i].size(); ++k)
      values.gradient(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
  j.at(6).get_to(values.no_gradient);
  j.at(7).get_to(values.of_reduced_leaves);
  return values;
}

Answerer evaluator_of(const DesignProblem& problem) {
  return [&problem](const std::string& question) {
    const json q = json::from_cbor(question);
    std::optional<Accuracy> accuracy;
    if (!q.at(2).is_null()) accuracy = static_cast<Accuracy>(q.at(2).get<int>());
    return packed(problem.evaluate(q.at(0).get<Variables>(), q.at(1).get<bool>(), accuracy));
  };
}

}  // namespace

DesignValues ask_evaluation(Crew& crew, const DesignProblem& problem, const Variables& variables,
                            bool gradient, std::optional<Accuracy> accuracy) {
  const json question{variables, gradient, accuracy ? json(static_cast<int>(*accuracy)) : json()};
  return unpacked(crew.ask(bytes_of(question), evaluator_of(problem)));
}

void answer_evaluations(Crew& crew, const DesignProblem& problem) {
  crew.answer(evaluator_of(problem));
}

}  // namespace flexopt
