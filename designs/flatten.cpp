#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "core/math/dual.hpp"
#include "core/mechanism/profile.hpp"
#include "core/spec/names.hpp"
#include "designs/flat_design.hpp"

namespace flexopt {

SpecError located(const ItemSource& item, const SpecError& error) {
  std::vector<Fault> faults = error.faults();
  for (Fault& fault : faults)
    if (fault.source.empty()) fault.rule += item.instance;
  return located(*item.source, SpecError(std::move(faults)));
}

namespace {

constexpr long most_copies = 1000;

/// Where an item's frame stands: global place = origin + axes · place. The axes are orthonormal,
/// and left-handed where a part is mirrored.
template <class S>
struct Placement {
  Vector3<S> origin = Vector3<S>::Zero();
  Matrix3<S> axes = Matrix3<S>::Identity();
  bool mirrored = false;
  bool plain = true;  ///< that of the file: nothing to compute, nothing to round

  Vector3<S> direction(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(axes.lazyProduct(v));
  }
  Vector3<S> place(const Vector3<S>& v) const {
    return plain ? v : Vector3<S>(origin + direction(v));
  }
  /// The direction of a leaf's width: its normal is reflected with the leaf, not against it.
  Vector3<S> across(const Vector3<S>& v) const {
    return mirrored ? Vector3<S>(-direction(v)) : direction(v);
  }
  Matrix3<S> tensor(const Matrix3<S>& t) const {
    if (plain) return t;
    const Matrix3<S> left = axes.lazyProduct(t);
    return left.lazyProduct(axes.transpose());
  }
  Placement inside(const Vector3<S>& at, const Matrix3<S>& turned, bool reflects) const {
    Placement inner;
    inner.origin = place(at);
    inner.axes = plain ? turned : Matrix3<S>(axes.lazyProduct(turned));
    inner.mirrored = mirrored != reflects;
    inner.plain = false;
    return inner;
  }
};

template <class S>
Matrix3<S> turn_about(int axis, const S& angle) {
  using std::cos, std::sin;
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  Matrix3<S> turn = Matrix3<S>::Identity();
  turn(j, j) = turn(k, k) = cos(angle);
  turn(k, j) = sin(angle);
  turn(j, k) = -turn(k, j);
  return turn;
}

double evaluated(const Formula& formula, std::span<const double> slots, bool& finite) {
  const std::optional<double> value = formula.value(slots);
  finite = value.has_value();
  return value.value_or(0);
}

template <int n>
Dual<n> evaluated(const Formula& formula, std::span<const Dual<n>> slots, bool& finite) {
  const auto value = formula.evaluate<Dual<n>>(slots);
  finite = value.has_value();
  return value.value_or(Dual<n>(0));
}

bool is_word_letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Where a word stands in a text; npos where it does not.
std::size_t word_in(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word_letter(text[at - 1])) &&
        (end == text.size() || !is_word_letter(text[end])))
      return at;
  }
  return std::string::npos;
}

/// The profile's text with numbers in the place of its names, s aside.
std::string with_numbers(const Formula& profile, std::span<const double> slots) {
  std::string result, word;
  const auto& names = profile.names();
  const std::string& text = profile.text();
  for (std::size_t at = 0; at <= text.size(); ++at) {
    const char c = at < text.size() ? text[at] : ' ';
    if (is_word_letter(c)) {
      word += c;
      continue;
    }
    const auto named = std::ranges::find(names, word);
    if (!word.empty() && named != names.end() && word != "s") {
      const auto i = static_cast<std::size_t>(named - names.begin());
      const std::size_t slot = static_cast<std::size_t>(profile.slots()[i]);
      result += fmt::format("({}{})", slots[slot], profile.units()[i]);
    } else {
      result += word;
    }
    word.clear();
    if (at < text.size()) result += c;
  }
  return result;
}

/// Evaluates one plan and appends what it holds to the flat design.
template <class S>
class Flattener {
 public:
  /// Where the plan stands: `prefix` before names, `instance` for messages, and the bodies that are
  /// those of the file around it.
  struct Scope {
    Placement<S> placement;
    std::string prefix, instance;
    std::map<std::string, int> joined;
  };

  Flattener(const DesignPlan& plan, const DesignInput<S>& input, Scope scope, FlatDesign<S>& out,
            FaultList& faults)
      : plan_(plan), input_(input), scope_(std::move(scope)), out_(out), faults_(faults) {}

  /// The bodies of the plan by their names in it.
  std::map<std::string, int> run();

 private:
  bool take_numbers();
  void check_rules();
  std::string with_values(std::string text, const std::vector<double>& values) const;
  void collect_frames();
  Placement<S> frame(const std::string& name, const DesignItem& item);
  void add_body(const BodyItem& item);
  void add_part(const PartItem& item);
  void add_leaf(const LeafItem& item);
  void add_reinforced(FlatLeaf<S> leaf, const LeafItem& item);
  void add_joint(const JointItem& item);
  void add_spring(const SpringItem& item);
  void add_drive(const DriveItem& item);
  FlatLeaf<S> leaf_of(const LeafItem& item);
  FlatSize<S> size_along(const DesignSize& size, const std::string& pointer, const char* what);
  std::array<bool, 6> held(const BodyItem& item, const Placement<S>& at) const;

  template <class Item, class Add>
  void each(const std::vector<Item>& items, Add add);
  template <class Item, class Add>
  void each_copy(const Item& item, std::size_t index, Add add);

  S number(const DesignNumber& n) const;
  Vector3<S> vector(const DesignVector& v) const {
    return {number(v[0]), number(v[1]), number(v[2])};
  }
  S positive(const DesignNumber& n, const std::string& pointer, const char* what) const;
  std::string instance_name(const DesignItem& item, const std::string& text) const;
  int body(const DesignItem& item, const std::string& name, const char* key) const;
  ItemSource source_of(const DesignItem& item) const;

  const DesignPlan& plan_;
  const DesignInput<S>& input_;
  Scope scope_;
  FlatDesign<S>& out_;
  FaultList& faults_;
  std::vector<S> slots_;
  std::vector<std::pair<std::string, long>> copy_;  ///< indices of the copy at hand
  std::map<std::string, int> bodies_;
  struct Frame {
    const FrameItem* item;
    std::vector<S> slots;
    std::vector<std::pair<std::string, long>> copy;
  };
  std::map<std::string, Frame> frames_;
  std::vector<std::string> inside_;  ///< frames that are being resolved
};

template <class S>
S Flattener<S>::number(const DesignNumber& n) const {
  if (!n.formula) return S(n.constant);
  bool finite = false;
  S value = evaluated(*n.formula, std::span<const S>(slots_), finite);
  if (!finite)
    throw SpecError(n.formula->pointer(), n.formula->text(),
                    "it has no finite value at these parameters");
  return value;
}

template <class S>
S Flattener<S>::positive(const DesignNumber& n, const std::string& pointer,
                         const char* what) const {
  S value = number(n);
  if (!(value_of(value) > 0))
    throw SpecError(pointer, fmt::format("{:g}", value_of(value)),
                    fmt::format("{} must be positive", what));
  return value;
}

template <class S>
ItemSource Flattener<S>::source_of(const DesignItem& item) const {
  std::string instance = scope_.instance;
  if (!copy_.empty()) {
    std::vector<std::string> indices;
    for (const auto& [name, value] : copy_) indices.push_back(fmt::format("{} = {}", name, value));
    instance += fmt::format(" (copy {})", fmt::join(indices, ", "));
  }
  return {&plan_.source, item.pointer, std::move(instance)};
}

template <class S>
std::string Flattener<S>::instance_name(const DesignItem& item, const std::string& text) const {
  std::string name;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const std::size_t end = text[at] == '{' ? text.find('}', at) : std::string::npos;
    if (end == std::string::npos) {
      name += text[at];
      continue;
    }
    const std::string index = text.substr(at + 1, end - at - 1);
    const auto found = std::ranges::find(copy_, index, &std::pair<std::string, long>::first);
    if (found == copy_.end())
      throw SpecError(item.pointer, "\"" + text + "\"",
                      fmt::format("{{{}}} is no index of its repeat", index));
    name += std::to_string(found->second);
    at = end;
  }
  return name;
}

template <class S>
int Flattener<S>::body(const DesignItem& item, const std::string& name, const char* key) const {
  const std::string wanted = instance_name(item, name);
  if (const auto found = bodies_.find(wanted); found != bodies_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [own, index] : bodies_) known.push_back(own);
  throw SpecError(item.pointer + key, "\"" + wanted + "\"",
                  "there is no such body; " + known_names(wanted, known));
}

template <class S>
template <class Item, class Add>
void Flattener<S>::each_copy(const Item& item, std::size_t index, Add add) {
  if (index == item.repeat.size()) {
    faults_.attempt([&] {
      try {
        add(item);
      } catch (const SpecError& error) {
        throw located(source_of(item), error);
      }
    });
    return;
  }
  const RepeatIndex& repeat = item.repeat[index];
  const std::string pointer = item.pointer + "/repeat/" + repeat.name;
  const auto whole = [&](const DesignNumber& bound) {
    const double value = value_of(number(bound)), rounded = std::round(value);
    if (std::abs(value - rounded) > 1e-9 || std::abs(value) > 1e6)
      throw SpecError(pointer, fmt::format("{:g}", value), "an index is a whole number");
    return static_cast<long>(rounded);
  };
  long first = 0, last = -1;
  faults_.attempt([&] {
    try {
      first = whole(repeat.first);
      last = whole(repeat.last);
      if (last - first + 1 > most_copies)
        throw SpecError(pointer, fmt::format("{} copies", last - first + 1),
                        fmt::format("at most {} copies", most_copies));
    } catch (const SpecError& error) {
      last = first - 1;
      throw located(source_of(item), error);
    }
  });
  const std::size_t slots = slots_.size();
  // all indices have their slots from the first on, those further in not yet with their values
  if (index == 0) slots_.resize(slots + item.repeat.size(), S(0));
  for (long i = first; i <= last; ++i) {
    slots_[slots_.size() - item.repeat.size() + index] = S(static_cast<double>(i));
    copy_.emplace_back(repeat.name, i);
    each_copy(item, index + 1, add);
    copy_.pop_back();
  }
  if (index == 0) slots_.resize(slots);
}

template <class S>
template <class Item, class Add>
void Flattener<S>::each(const std::vector<Item>& items, Add add) {
  for (const Item& item : items)
    if (item.when.holds(*input_.choices)) each_copy(item, 0, add);
}

template <class S>
bool Flattener<S>::take_numbers() {
  slots_ = input_.parameters;
  for (std::size_t i = 0; i < plan_.lets.size(); ++i) {
    const bool sound = faults_.attempt([&] {
      try {
        slots_.push_back(number(plan_.let_numbers[i]));
      } catch (const SpecError& error) {
        throw located(plan_.source, error);
      }
    });
    if (!sound) return false;
  }
  return true;
}

/// "at most {width}" with the value of the parameter.
template <class S>
std::string Flattener<S>::with_values(std::string text, const std::vector<double>& values) const {
  for (std::size_t i = 0; i < plan_.parameters.size(); ++i) {
    const Parameter& p = plan_.parameters[i];
    const std::string name = "{" + p.name + "}";
    const std::string value = fmt::format("{:g}{}", values[i], p.unit == "1" ? "" : " " + p.unit);
    for (std::size_t at; (at = text.find(name)) != std::string::npos;)
      text.replace(at, name.size(), value);
  }
  return text;
}

template <class S>
void Flattener<S>::check_rules() {
  std::vector<double> values;
  for (const S& x : slots_) values.push_back(value_of(x));
  for (const DesignRule& rule : plan_.rules) {
    const std::optional<double> holds = rule.that.value(values);
    if (holds && *holds != 0) continue;
    std::string pointer = rule.pointer, value = rule.that.text();
    // shown at the parameter that the rule names first
    std::size_t first = std::string::npos;
    for (const Parameter& p : plan_.parameters) {
      const std::size_t at = word_in(rule.that.text(), p.name);
      if (at >= first || !scope_.prefix.empty()) continue;
      first = at;
      pointer = "/design/parameters/" + p.name;
      value = fmt::format("{:g}{}", values[static_cast<std::size_t>(&p - plan_.parameters.data())],
                          p.unit == "1" ? "" : " " + p.unit);
    }
    faults_.add(located(plan_.source,
                        SpecError(pointer, value,
                                  fmt::format("{} ({}){}", with_values(rule.otherwise, values),
                                              rule.that.text(), scope_.instance))));
  }
}

template <class S>
void Flattener<S>::collect_frames() {
  each(plan_.frames, [&](const FrameItem& item) {
    const std::string name = instance_name(item, item.name);
    if (!frames_.try_emplace(name, Frame{&item, slots_, copy_}).second)
      throw SpecError(item.pointer + "/name", "\"" + name + "\"", "another frame has this name");
  });
  for (const auto& [name, frame] : frames_)
    faults_.attempt([&] { (void)this->frame(name, *frame.item); });
}

template <class S>
Placement<S> Flattener<S>::frame(const std::string& name, const DesignItem& item) {
  if (name.empty()) return scope_.placement;
  const std::string wanted = instance_name(item, name);
  const auto found = frames_.find(wanted);
  if (found == frames_.end()) {
    std::vector<std::string> known;
    for (const auto& [own, frame] : frames_) known.push_back(own);
    throw SpecError(item.pointer + "/frame", "\"" + wanted + "\"",
                    "there is no such frame; " + known_names(wanted, known));
  }
  if (std::ranges::find(inside_, wanted) != inside_.end())
    throw SpecError(item.pointer, "\"" + wanted + "\"", "frames stand in each other in a circle");
  inside_.push_back(wanted);
  const auto slots = std::exchange(slots_, found->second.slots);
  const auto copy = std::exchange(copy_, found->second.copy);
  const auto restore = [&] {
    slots_ = slots;
    copy_ = copy;
    inside_.pop_back();
  };
  try {
    const FrameItem& own = *found->second.item;
    const Placement<S> outer = frame(own.frame, own);
    Matrix3<S> turned = Matrix3<S>::Identity();
    for (const FrameItem::Turn& turn : own.turns)
      turned = Matrix3<S>(turned.lazyProduct(turn_about<S>(turn.axis, number(turn.angle))));
    Placement<S> result = outer.inside(vector(own.at), turned, false);
    restore();
    return result;
  } catch (...) {
    restore();
    throw;
  }
}

template <class S>
std::array<bool, 6> Flattener<S>::held(const BodyItem& item, const Placement<S>& at) const {
  std::array<bool, 6> result{};
  for (const Direction direction : item.held) {
    const int axis = index(direction) % 3;
    int global = -1;
    for (int i = 0; i < 3; ++i)
      if (std::abs(std::abs(value_of(at.axes(i, axis))) - 1) < 1e-12) global = i;
    if (global < 0)
      throw SpecError(item.pointer + "/held", std::string(direction_names[index(direction)]),
                      "a held direction lies along a global axis: its frame may stand in quarter "
                      "turns only");
    result[static_cast<std::size_t>(global + (is_rotation(direction) ? 3 : 0))] = true;
  }
  return result;
}

template <class S>
void Flattener<S>::add_body(const BodyItem& item) {
  const std::string name = instance_name(item, item.name);
  if (bodies_.contains(name)) {
    if (scope_.joined.contains(name)) return;  // the body of the file around it stands for it
    throw SpecError(item.pointer + "/name", "\"" + name + "\"", "another body has this name");
  }
  const Placement<S> at = frame(item.frame, item);
  FlatBody<S> body;
  body.name = scope_.prefix + name;
  body.source = source_of(item);
  body.at = at.place(vector(item.at));
  if (!item.leaf.empty()) {
    body.leaf = scope_.prefix + instance_name(item, item.leaf);
    body.held = {false, false, false, true, true, true};
  } else {
    body.held = held(item, at);
    body.has_mass = item.mass || item.density || !item.inertia.empty();
    body.center_of_mass = at.direction(vector(item.center_of_mass));
    if (item.mass) body.mass = number(*item.mass);
    Matrix3<S> inertia = Matrix3<S>::Zero();
    if (item.inertia.size() == 3)
      for (int i = 0; i < 3; ++i) inertia(i, i) = number(item.inertia[static_cast<std::size_t>(i)]);
    if (item.inertia.size() == 9)
      for (int i = 0; i < 9; ++i)
        inertia(i / 3, i % 3) = number(item.inertia[static_cast<std::size_t>(i)]);
    if (item.box) {
      std::array<S, 3> l;
      for (std::size_t i = 0; i < 3; ++i)
        l[i] = positive((*item.box)[i], item.pointer + "/box", "the lengths of a box");
      if (item.density) {
        body.mass = number(*item.density) * l[0] * l[1] * l[2];
        for (int i = 0; i < 3; ++i) {
          const S &a = l[static_cast<std::size_t>((i + 1) % 3)],
                  &b = l[static_cast<std::size_t>((i + 2) % 3)];
          inertia(i, i) = body.mass * (a * a + b * b) / 12.0;
        }
      }
    }
    body.inertia = at.tensor(inertia);
  }
  bodies_[name] = static_cast<int>(out_.bodies.size());
  if (scope_.prefix.empty() && name == "end_effector")
    out_.end_effector = static_cast<int>(out_.bodies.size());
  out_.bodies.push_back(std::move(body));
}

template <class S>
FlatLeaf<S> Flattener<S>::leaf_of(const LeafItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatLeaf<S> leaf;
  leaf.name = scope_.prefix + instance_name(item, item.name);
  leaf.source = source_of(item);
  leaf.base = body(item, item.base.body, "/base/body");
  leaf.tip = item.tip.body.empty() ? free_edge : body(item, item.tip.body, "/tip/body");
  leaf.base_at = at.place(vector(item.base.at));
  leaf.tip_at = at.place(vector(item.tip.at));
  leaf.across = at.across(vector(item.across));
  leaf.wire = item.wire;
  const std::string thick = item.pointer + (item.wire ? "/diameter" : "/thickness");
  if (item.curve)
    throw SpecError(item.pointer + "/curve", "\"" + leaf.name + "\"",
                    "this version does not offer curved leaves");
  leaf.thickness = size_along(item.thickness, thick, item.wire ? "a diameter" : "a thickness");
  leaf.width =
      item.wire ? leaf.thickness : size_along(item.width, item.pointer + "/width", "a width");
  leaf.material = item.material;
  return leaf;
}

template <class S>
FlatSize<S> Flattener<S>::size_along(const DesignSize& size, const std::string& pointer,
                                     const char* what) {
  FlatSize<S> result;
  if (!size.profile) {
    result.values.push_back(positive(size.base, pointer, what));
    if (size.tip) result.values.push_back(positive(*size.tip, pointer, what));
    return result;
  }
  slots_.push_back(S(0));
  for (const double s : profile_stations()) {
    slots_.back() = S(s);
    result.values.push_back(positive({0, size.profile}, pointer + "/profile", what));
  }
  slots_.pop_back();
  std::vector<double> numbers;
  for (const S& x : slots_) numbers.push_back(value_of(x));
  result.formula = with_numbers(*size.profile, numbers);
  return result;
}

template <class S>
void Flattener<S>::add_leaf(const LeafItem& item) {
  FlatLeaf<S> leaf = leaf_of(item);
  if (std::ranges::find(out_.leaves, leaf.name, &FlatLeaf<S>::name) != out_.leaves.end())
    throw SpecError(item.pointer + "/name", "\"" + leaf.name + "\"", "another leaf has this name");
  if (item.reinforcement)
    add_reinforced(std::move(leaf), item);
  else
    out_.leaves.push_back(std::move(leaf));
}

/// Two leaves and a rigid box between them.
template <class S>
void Flattener<S>::add_reinforced(FlatLeaf<S> leaf, const LeafItem& item) {
  using std::sqrt;
  const std::string pointer = item.pointer + "/reinforcement";
  const S fraction = number(item.reinforcement->fraction);
  const S thickness = positive(item.reinforcement->thickness, pointer + "/thickness",
                               "the thickness of a reinforcement");
  if (!(value_of(fraction) > 0 && value_of(fraction) < 1))
    throw SpecError(pointer + "/fraction", fmt::format("{:g}", value_of(fraction)),
                    "it is a part of the length: 0 < fraction < 1");
  if (leaf.width.values.size() > 1 || leaf.thickness.values.size() > 1)
    throw SpecError(pointer, "\"" + leaf.name + "\"", "only a uniform leaf is reinforced");
  const S width = leaf.width.values.front();
  const Vector3<S> line = leaf.tip_at - leaf.base_at;
  const S part = (S(1) - fraction) * 0.5, length = fraction * line.norm();
  const S density = leaf.material ? S(leaf.material->density) : input_.material.density;
  Matrix3<S> axes;
  axes.col(0) = line / line.norm();
  const S along = axes.col(0).dot(leaf.across);
  axes.col(1) = leaf.across - axes.col(0) * along;
  axes.col(1) /= S(axes.col(1).norm());
  axes.col(2) = Vector3<S>(axes.col(0)).cross(Vector3<S>(axes.col(1)));

  FlatBody<S> box;
  box.name = leaf.name + "/reinforcement";
  box.source = leaf.source;
  box.at = (leaf.base_at + leaf.tip_at) * S(0.5);
  box.has_mass = true;
  box.mass = density * length * width * thickness;
  const std::array<S, 3> l{length, width, thickness};
  Matrix3<S> inertia = Matrix3<S>::Zero();
  for (int i = 0; i < 3; ++i) {
    const S &a = l[static_cast<std::size_t>((i + 1) % 3)],
            &b = l[static_cast<std::size_t>((i + 2) % 3)];
    inertia(i, i) = box.mass * (a * a + b * b) / 12.0;
  }
  const Matrix3<S> left = axes.lazyProduct(inertia);
  box.inertia = left.lazyProduct(axes.transpose());
  const int middle = static_cast<int>(out_.bodies.size());
  out_.bodies.push_back(std::move(box));

  FlatLeaf<S> first = leaf, second = leaf;
  first.name += "/base";
  first.tip = middle;
  first.tip_at = leaf.base_at + line * part;
  second.name += "/tip";
  second.base = middle;
  second.base_at = leaf.tip_at - line * part;
  out_.leaves.push_back(std::move(first));
  out_.leaves.push_back(std::move(second));
}

template <class S>
void Flattener<S>::add_joint(const JointItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatJoint<S> joint;
  joint.name = scope_.prefix + instance_name(item, item.name);
  if (std::ranges::find(out_.joints, joint.name, &FlatJoint<S>::name) != out_.joints.end())
    throw SpecError(item.pointer + "/name", "\"" + joint.name + "\"",
                    "another joint has this name");
  joint.source = source_of(item);
  joint.type = item.type;
  joint.body = body(item, item.body, "/body");
  joint.other = body(item, item.other, "/other");
  joint.at = at.place(vector(item.at));
  const Vector3<S> axis = at.direction(vector(item.axis));
  const S length = axis.norm();
  if (!(value_of(length) > 0))
    throw SpecError(item.pointer + "/axis", "0", "an axis has a direction");
  joint.axis = value_of(length) == 1 ? axis : Vector3<S>(axis / length);
  out_.joints.push_back(std::move(joint));
}

template <class S>
void Flattener<S>::add_drive(const DriveItem& item) {
  const Placement<S> at = frame(item.frame, item);
  FlatDrive<S> drive;
  drive.name = item.name;
  drive.source = source_of(item);
  drive.body = body(item, item.body, "/body");
  drive.other = body(item, item.other, "/other");
  drive.direction = item.direction;
  drive.axes = at.axes;
  out_.drives.push_back(std::move(drive));
}

template <class S>
void Flattener<S>::add_part(const PartItem& item) {
  const std::string name = instance_name(item, item.name);
  DesignInput<S> input;
  for (std::size_t i = 0; i < item.parameters.size(); ++i) {
    const Parameter& p = item.design->parameters[i];
    input.parameters.push_back(number(item.parameters[i]));
    const double value = value_of(input.parameters.back());
    const bool low = p.open_min ? value > p.min : value >= p.min;
    const bool high = p.open_max ? value < p.max : value <= p.max;
    if (!low || !high)
      throw SpecError(item.pointer + "/parameters/" + p.name, fmt::format("{:g}", value),
                      fmt::format("the part wants {} in {}{:g}, {:g}{}", p.name,
                                  p.open_min ? "(" : "[", p.min, p.max, p.open_max ? ")" : "]"));
  }
  input.choices = &item.choices;
  input.material = input_.material;
  typename Flattener::Scope scope;
  scope.placement = frame(item.frame, item);
  if (item.mirror >= 0) {
    Matrix3<S> reflection = Matrix3<S>::Identity();
    reflection(item.mirror, item.mirror) = S(-1);
    scope.placement = scope.placement.inside(Vector3<S>(S(0), S(0), S(0)), reflection, true);
  }
  scope.prefix = scope_.prefix + name + "/";
  scope.instance = source_of(item).instance + " (part " + scope_.prefix + name + ")";
  for (const auto& [inner, outer] : item.join)
    scope.joined[instance_name(item, inner)] = body(item, outer, "/join");
  FaultList faults;
  const auto inner = Flattener(*item.design, input, std::move(scope), out_, faults).run();
  if (!faults.faults().empty()) throw SpecError(faults.faults());
  for (const auto& [own, index] : inner)
    if (own != "ground") bodies_[name + "/" + own] = index;
}

template <class S>
std::map<std::string, int> Flattener<S>::run() {
  bodies_ = scope_.joined;
  bodies_.try_emplace("ground", ground);
  if (!take_numbers()) return bodies_;
  check_rules();
  collect_frames();
  each(plan_.bodies, [&](const BodyItem& item) { add_body(item); });
  for (const auto& [name, index] : scope_.joined) {
    const auto known = [&](const BodyItem& item) { return item.name == name; };
    if (name != "ground" && std::ranges::none_of(plan_.bodies, known))
      faults_.add("/join", "\"" + name + "\"", "the part has no such body" + scope_.instance);
  }
  each(plan_.parts, [&](const PartItem& item) { add_part(item); });
  each(plan_.leaves, [&](const LeafItem& item) { add_leaf(item); });
  each(plan_.joints, [&](const JointItem& item) { add_joint(item); });
  each(plan_.springs, [&](const SpringItem& item) { add_spring(item); });
  if (scope_.prefix.empty()) {
    out_.named_drives = plan_.named_drives;
    each(plan_.drives, [&](const DriveItem& item) { add_drive(item); });
    if (out_.end_effector < 0 && faults_.faults().empty())
      faults_.add(located(
          plan_.source,
          SpecError("/bodies", "nothing", "one body is called end_effector: it carries O")));
  }
  return bodies_;
}

template <class S>
void Flattener<S>::add_spring(const SpringItem& item) {
  const Placement<S> at = frame(item.frame, item);
  SpringT<S> spring;
  spring.name = scope_.prefix + instance_name(item, item.name);
  spring.body = body(item, item.body, "/body");
  spring.other = body(item, item.other, "/other");
  spring.place = at.place(vector(item.at));
  spring.other_place = spring.place;
  if (item.matrix.empty()) {
    spring.other_place = at.place(vector(item.other_at));
    spring.stiffness = number(item.stiffness);
    spring.free_length = item.free_length ? number(*item.free_length)
                                          : S(Vector3<S>(spring.other_place - spring.place).norm());
  } else {
    Matrix6<S> matrix, turn = Matrix6<S>::Zero();
    for (int i = 0; i < 36; ++i)
      matrix(i / 6, i % 6) = number(item.matrix[static_cast<std::size_t>(i)]);
    turn.template topLeftCorner<3, 3>() = at.axes;
    turn.template bottomRightCorner<3, 3>() = at.mirrored ? Matrix3<S>(-at.axes) : at.axes;
    if (!at.plain) {
      const Matrix6<S> left = turn.lazyProduct(matrix);
      matrix = left.lazyProduct(turn.transpose());
    }
    spring.matrix = matrix;
  }
  out_.springs.push_back({source_of(item), std::move(spring)});
}

}  // namespace

template <class S>
FlatDesign<S> flatten(const DesignPlan& plan, const DesignInput<S>& input) {
  FlatDesign<S> design;
  FaultList faults;
  Flattener<S>(plan, input, {}, design, faults).run();
  faults.raise();
  return design;
}

template FlatDesign<double> flatten(const DesignPlan&, const DesignInput<double>&);
template FlatDesign<Dual1> flatten(const DesignPlan&, const DesignInput<Dual1>&);

}  // namespace flexopt
