#include <algorithm>
#include <utility>

#include "results/export/parts.hpp"
#include "results/export/view_picture.hpp"

namespace flexopt {

namespace {

constexpr double plan_width = 520, plan_height = 500, largest_slanting = 290, between_views = 36,
                 narrowest = 620, row = 17;  // px

/// Scale at which the plan views fit side by side and below each other.
double scale_of(const PlacedDesign& design, const MeasuredDesign& measured) {
  Point2 room = room_of(design, plan_views()[0]);
  for (const MeasuredView& one : measured.views) {
    if (one.view.caption == plan_views()[1].caption) room[1] += room_of(design, one.view)[1];
    if (one.view.caption == plan_views()[2].caption) room[0] += room_of(design, one.view)[0];
  }
  return std::min(plan_width / room[0], plan_height / room[1]);
}

struct Cell {
  Picture picture;
  int column = 0, line = 0;
};

/// Front, below it the view from below, to its right that from the right, each on the front's
/// axes; then the slanting view, and leaves on their own in a line below.
std::vector<Cell> cells_of(const PlacedDesign& design, const MeasuredDesign& measured) {
  const double scale = scale_of(design, measured);
  std::vector<Cell> cells;
  int right = 1, below = 1, alone = 0;
  const auto centered = [](Picture picture) {
    picture.move(-picture.extent().center());
    return picture;
  };
  for (const MeasuredView& one : measured.views) {
    Cell cell{view_picture(design, one, scale)};
    if (!one.view.leaves.empty()) {
      cell.picture = centered(std::move(cell.picture));
      cell.column = alone++;
      cell.line = 2;
    } else if (one.view.caption == plan_views()[1].caption) {
      cell.line = 1;
      below = 2;
    } else if (one.view.caption == plan_views()[2].caption) {
      cell.column = 1;
      right = 2;
    }
    cells.push_back(std::move(cell));
  }
  const bool corner = below == 2 && right == 2;
  cells.push_back(
      {centered(slanting_picture(design, largest_slanting)), corner ? 1 : right, corner ? 1 : 0});
  return cells;
}

/// Columns and lines as wide as what stands in them needs on either side of its axis.
Picture arranged(std::vector<Cell> cells) {
  std::size_t most = 0;
  for (const Cell& cell : cells)
    most = std::max(most, static_cast<std::size_t>(std::max(cell.column, cell.line)) + 1);
  for (int k = 0; k < 2; ++k) {
    const auto place = [&](const Cell& cell) { return k == 0 ? cell.column : cell.line; };
    std::vector<double> before(most), behind(most);
    for (const Cell& cell : cells) {
      const auto at = static_cast<std::size_t>(place(cell));
      const Box2 box = cell.picture.extent();
      before[at] = std::max(before[at], -box.min()[k]);
      behind[at] = std::max(behind[at], box.max()[k]);
    }
    for (Cell& cell : cells) {
      double start = 0;
      for (std::size_t at = 0; at < static_cast<std::size_t>(place(cell)); ++at)
        start += before[at] + behind[at] + (before[at] + behind[at] > 0 ? between_views : 0);
      Point2 by = Point2::Zero();
      by[k] = start + before[place(cell)];
      cell.picture.move(by);
    }
  }
  Picture all;
  for (const Cell& cell : cells) all.append(cell.picture);
  all.move(-all.extent().min());
  return all;
}

void add_lines(const std::vector<std::string>& lines, const Point2& at, double size,
               const std::string& style, Picture& picture) {
  for (std::size_t i = 0; i < lines.size(); ++i)
    picture.labels.push_back(
        label_at(lines[i], at + Point2(0, row * static_cast<double>(i)), size, style));
}

/// Name, value and meaning of every parameter, then the choices.
Picture table_of(const Family& family, const ParameterValues& values, const FamilyChoices& choices,
                 double width) {
  struct Row {
    std::string name, value, meaning;
  };
  std::vector<Row> rows;
  for (const Parameter& p : family.parameters)
    rows.push_back({p.name, with_drawn_unit(values.at(p.name), p.unit), p.meaning});
  for (const FamilyOption& option : family.options)
    rows.push_back({option.name, choices.at(option.name), option.meaning});
  double names = 0, numbers = 0;
  for (const Row& one : rows) {
    names = std::max(names, size_of_text(one.name, 12)[0]);
    numbers = std::max(numbers, size_of_text(one.value, 12)[0]);
  }
  const double second = names + 18, third = second + numbers + 18;
  Picture table;
  double y = 0;
  for (const Row& one : rows) {
    table.line("rule", {{0, y - 3}, {width, y - 3}});
    table.labels.push_back(label_at(one.name, {0, y}));
    table.labels.push_back(label_at(one.value, {second, y}));
    const auto meaning = wrapped(one.meaning, width - third, 12);
    add_lines(meaning, {third, y}, 12, "quiet", table);
    y += row * static_cast<double>(meaning.size()) + 4;
  }
  return table;
}

/// Adds a note in the front view, at the place that the parameter moves most.
void add_note(const PlacedDesign& design, std::size_t parameter, Cell& front, double scale) {
  const auto most = std::ranges::max_element(
      design.points, {}, [&](const DrawnPoint& p) { return p.rates[parameter].norm(); });
  const Eigen::Vector2d at = scale * plan_views()[0](most->at);
  const Parameter& p = design.parameters[parameter];
  add_note(p.name + " = " + with_drawn_unit(design.values[parameter], p.unit), {at[0], -at[1]},
           front.picture);
}

}  // namespace

DesignDrawing draw_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices) {
  const PlacedDesign design = placed_design(family, values, choices);
  const MeasuredDesign measured = measured_design(design);
  std::vector<Cell> cells = cells_of(design, measured);
  DesignDrawing drawing;
  for (const std::size_t k : measured.without) {
    add_note(design, k, cells.front(), scale_of(design, measured));
    drawing.without_dimension.push_back(design.parameters[k].name);
  }
  Picture& page = drawing.picture;
  page = arranged(std::move(cells));
  const double width = std::max(narrowest, page.extent().max()[0]);
  std::string words = family.summary;
  for (const std::string& name : bodies_without_mesh(design.mechanism))
    words += " Elastic body " + name + ", matrices of another program, is not drawn.";
  const std::vector<std::string> summary = wrapped(words, width, 12);
  page.move({0, 34 + row * static_cast<double>(summary.size()) + 14});
  page.labels.push_back(label_at(family.name, {0, 0}, 18, "title"));
  add_lines(summary, {0, 28}, 12, "label", page);
  Picture table = table_of(family, values, choices, width);
  table.move({0, page.extent().max()[1] + 26});
  page.append(table);
  return drawing;
}

std::string svg_of_design(const Family& family, const ParameterValues& values,
                          const FamilyChoices& choices) {
  return svg_of(draw_design(family, values, choices).picture, family.name);
}

}  // namespace flexopt
