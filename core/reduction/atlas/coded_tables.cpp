#include "core/reduction/atlas/coded_tables.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include "core/math/decompositions.hpp"
#include "core/reduction/atlas/direction_sums.hpp"

namespace flexopt {
namespace {

// A table as bytes: its rows, the number of each row among all (rows fill up the last block), for
// each block how many directions it has in 32, to 16 and to 8 bits (and a zero), then the blocks.
struct TableView {
  std::uint32_t rows = 0;
  const std::uint16_t* numbers = nullptr;
  const std::uint16_t* directions = nullptr;
  const char* blocks = nullptr;

  explicit TableView(std::string_view bytes) {
    std::memcpy(&rows, bytes.data(), sizeof rows);
    numbers = reinterpret_cast<const std::uint16_t*>(bytes.data() + sizeof rows);
    directions = numbers + block_count() * direction_block;
    blocks = reinterpret_cast<const char*>(directions + 4 * block_count());
  }
  std::size_t block_count() const { return (rows + direction_block - 1) / direction_block; }
};

template <class T>
void append(std::string& bytes, const T* data, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

// The numbers of a table in their places, each by its size and law, then their slopes.
template <int several>
void put_table(const TableView& table, const CodedTables::Place& at, const float* sizes,
               const PowerLaw* laws, MatrixXd& found) {
  const char* block = table.blocks;
  for (std::size_t b = 0; b < table.block_count(); ++b) {
    std::array<double, static_cast<std::size_t>(several) * direction_block> y{};
    int from = 0;
    const auto add = [&]<class Whole>(const Whole* rows, int to) {
      add_direction_sums<several>(rows, to - from, at.coordinates.data() + several * from,
                                  y.data());
      block += static_cast<std::size_t>(to - from) * direction_block * sizeof(Whole);
      from = to;
    };
    const std::uint16_t* const directions = table.directions + 4 * b;
    add(reinterpret_cast<const std::int32_t*>(block), directions[0]);
    add(reinterpret_cast<const std::int16_t*>(block), directions[1]);
    add(reinterpret_cast<const std::int8_t*>(block), directions[2]);
    const std::size_t first = b * direction_block,
                      count = std::min<std::size_t>(direction_block, table.rows - first);
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint16_t number = table.numbers[first + i];
      const double size = static_cast<double>(sizes[number]) * at.law(laws[number]);
      double* to = found.data() + number;
      const double value = *to = size * y[i];
      for (std::size_t j = 1; j < several; ++j)
        *(to += found.rows()) =
            size * y[j * direction_block + i] + (j < 3 ? 0.5 * laws[number][j - 1] * value : 0);
    }
  }
}

}  // namespace

CodedTables::CodedTables(ShapeGrid grid, std::vector<int> counts, AtlasPart common,
                         std::vector<AtlasPart> tables)
    : grid_(std::move(grid)),
      counts_(std::move(counts)),
      common_(std::move(common)),
      tables_(std::move(tables)) {
  first_.push_back(0);
  for (const int count : counts_) first_.push_back(first_.back() + static_cast<std::size_t>(count));
}

const CodedTables::Common& CodedTables::read() const {
  std::call_once(once_, [&] {
    const std::size_t numbers = first_.back();
    const char* at = common_.bytes().data();
    known_.sizes = reinterpret_cast<const float*>(at);
    known_.laws = reinterpret_cast<const PowerLaw*>(at += numbers * sizeof(float));
    at += (numbers + numbers % 2) * sizeof(PowerLaw);
    const Eigen::Index shapes = grid_.size(),
                       rest = common_.bytes().data() + common_.bytes().size() - at;
    known_.coordinates = Eigen::Map<const Eigen::MatrixXf>(
                             reinterpret_cast<const float*>(at),
                             rest / (shapes * static_cast<Eigen::Index>(sizeof(float))), shapes)
                             .cast<double>();
  });
  return known_;
}

CodedTables::Place CodedTables::place(const PlateShape& shape, ShapeSlopes slopes) const {
  const Vector3d at = place_in_grid(shape);
  const MatrixXd found = read().coordinates * shape_weights(grid_, at, slopes);
  return {found.transpose(), HalfPowers(at)};
}

MatrixXd CodedTables::look_up(int ray, int node, const Place& at) const {
  const Common& common = read();
  const auto n = static_cast<std::size_t>(node);
  MatrixXd found = MatrixXd::Zero(counts_[n], at.coordinates.rows());
  const TableView table(tables_[static_cast<std::size_t>(ray) * counts_.size() + n].bytes());
  const auto put = [&]<int several>() {
    put_table<several>(table, at, common.sizes + first_[n], common.laws + first_[n], found);
  };
  switch (found.cols()) {
    case 1:
      put.template operator()<1>();
      break;
    case 3:
      put.template operator()<3>();
      break;
    default:
      put.template operator()<4>();
  }
  return found;
}

// ---------------------------------------------------------------------------- coding

namespace {

using WholeNumbers = Eigen::Matrix<std::int32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// How many directions of a row are in 32, to 16 and to 8 bits.
using Widths = std::array<std::uint16_t, 4>;
Widths widths_of(const WholeNumbers& U, Eigen::Index row) {
  Widths widths{};
  constexpr std::array<std::int32_t, 3> beyond{32767, 127, 0};
  for (Eigen::Index k = 0; k < U.cols(); ++k)
    for (std::size_t w = 0; w < 3; ++w)
      if (std::abs(U(row, k)) > beyond[w]) widths[w] = static_cast<std::uint16_t>(k + 1);
  return widths;
}

template <class Whole>
void append_block(std::string& bytes, const WholeNumbers& U, const Eigen::Index* rows,
                  std::size_t count, int from, int to) {
  for (int k = from; k < to; ++k) {
    std::array<Whole, direction_block> column{};
    for (std::size_t i = 0; i < count; ++i) column[i] = static_cast<Whole>(U(rows[i], k));
    append(bytes, column.data(), column.size());
  }
}

std::string table_bytes(const WholeNumbers& U) {
  std::vector<Widths> widths;
  std::vector<Eigen::Index> rows;  // that count, similar ones beside each other
  for (Eigen::Index i = 0; i < U.rows(); ++i)
    if (widths.push_back(widths_of(U, i)); widths.back()[2] > 0) rows.push_back(i);
  const auto key = [&](Eigen::Index i) {
    const Widths& w = widths[static_cast<std::size_t>(i)];
    return std::array{w[2], w[1], w[0]};
  };
  std::ranges::stable_sort(rows, {}, key);
  std::string bytes, blocks;
  const auto count = static_cast<std::uint32_t>(rows.size());
  append(bytes, &count, 1);
  std::vector<std::uint16_t> numbers(rows.begin(), rows.end());
  numbers.resize((rows.size() + direction_block - 1) / direction_block * direction_block);
  append(bytes, numbers.data(), numbers.size());
  for (std::size_t first = 0; first < rows.size(); first += direction_block) {
    const std::size_t in_block = std::min<std::size_t>(direction_block, rows.size() - first);
    Widths most{};
    for (std::size_t i = 0; i < in_block; ++i)
      for (std::size_t w = 0; w < 3; ++w)
        most[w] = std::max(most[w], widths[static_cast<std::size_t>(rows[first + i])][w]);
    append(bytes, most.data(), most.size());
    const Eigen::Index* const of = rows.data() + first;
    append_block<std::int32_t>(blocks, U, of, in_block, 0, most[0]);
    append_block<std::int16_t>(blocks, U, of, in_block, most[0], most[1]);
    append_block<std::int8_t>(blocks, U, of, in_block, most[1], most[2]);
  }
  return bytes + blocks;
}

}  // namespace

std::shared_ptr<const CodedTables> code_tables(const ShapeGrid& grid, const VectorXd& share,
                                               const std::vector<NumberUnits>& units,
                                               std::vector<std::vector<NumbersOfShapes>> values) {
  constexpr double least = 0.6;           // of a unit: what is smaller is left out
  constexpr double of_coordinates = 0.1;  // of a unit, by the rounding of one coordinate
  const MatrixXd log_sizes = grid.log_sizes();
  const Eigen::Index shapes = grid.size();
  assert(share.size() == shapes);
  // in units, times the share of their shape
  MatrixXd gram = MatrixXd::Zero(shapes, shapes);
  for (std::vector<NumbersOfShapes>& ray : values)
    for (std::size_t n = 0; n < ray.size(); ++n) {
      assert(ray[n].cols() == shapes && ray[n].rows() <= 65536);
      for (Eigen::Index i = 0; i < ray[n].rows(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        const VectorXd unit =
            static_cast<double>(units[n].sizes[k]) * law_at(log_sizes, units[n].laws[k]);
        ray[n].row(i) = (ray[n].row(i).cast<double>().array() * share.transpose().array() /
                         unit.transpose().array())
                            .cast<float>();
      }
      const MatrixXd scaled = ray[n].cast<double>();
      gram.noalias() += scaled.transpose() * scaled;
    }
  // the right singular vectors of all numbers together, largest first
  const MatrixXd V = SymmetricEigen(gram).eigenvectors().rowwise().reverse();
  std::vector<AtlasPart> tables;
  Eigen::ArrayXd most = Eigen::ArrayXd::Zero(shapes);  // along each direction
  for (std::vector<NumbersOfShapes>& ray : values)
    for (NumbersOfShapes& numbers : ray) {
      MatrixXd along = numbers.cast<double>() * V;
      numbers.resize(0, 0);
      along = along.unaryExpr([](double x) { return std::abs(x) < least ? 0.0 : std::round(x); });
      if (along.rows() > 0)
        most = most.max(along.cwiseAbs().colwise().maxCoeff().transpose().array());
      tables.emplace_back(table_bytes(along.cast<std::int32_t>()));
    }
  Eigen::Index directions = shapes;
  while (directions > 0 && most[directions - 1] == 0) --directions;

  std::string common;
  std::vector<int> counts;
  for (const NumberUnits& of : units) {
    append(common, of.sizes.data(), of.sizes.size());
    counts.push_back(static_cast<int>(of.sizes.size()));
  }
  for (const NumberUnits& of : units) append(common, of.laws.data(), of.laws.size());
  if (std::reduce(counts.begin(), counts.end()) % 2 == 1) common.append(sizeof(PowerLaw), '\0');
  Eigen::MatrixXf coordinates(directions, shapes);
  for (Eigen::Index k = 0; k < directions; ++k) {
    const double unit = std::exp2(std::floor(std::log2(of_coordinates / std::max(1.0, most[k]))));
    coordinates.row(k) =
        (unit * (V.col(k).array() / share.array() / unit).round()).transpose().cast<float>();
  }
  append(common, coordinates.data(), static_cast<std::size_t>(coordinates.size()));
  return std::make_shared<CodedTables>(grid, std::move(counts), AtlasPart(std::move(common)),
                                       std::move(tables));
}

}  // namespace flexopt
