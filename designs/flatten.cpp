#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/math/dual.hpp"
#include "core/spec/names.hpp"
#include "designs/design_reader.hpp"
#include "designs/flattener.hpp"

namespace flexopt {

SpecError located(const ItemSource& item, const SpecError& error) {
  std::vector<Fault> faults = error.faults();
  const auto is_new = [](const Fault& fault) { return fault.source.empty() && !is_of_job(fault); };
  for (Fault& fault : faults)
    if (is_new(fault)) fault.rule += item.instance;
  const ItemSource* at = &item;
  for (; at->source->kind != DesignSource::Kind::file && at->part; at = at->part.get())
    for (Fault& fault : faults) {
      if (!is_new(fault)) continue;
      if (at->source->kind == DesignSource::Kind::library)
        show_at(at->part->pointer, *at->source, fault);
      else
        fault.pointer = at->source->lead + fault.pointer;
    }
  return located(*at->source, SpecError(std::move(faults)));
}

namespace {

constexpr long most_copies = 1000;

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

}  // namespace

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
void Flattener<S>::not_negative(const DesignNumber& n, const std::string& pointer,
                                const char* what) const {
  if (const double value = value_of(number(n)); !(value >= 0))
    throw SpecError(pointer, fmt::format("{:g}", value), fmt::format("{} is not negative", what));
}

template <class S>
long Flattener<S>::whole(const DesignNumber& n, const std::string& pointer,
                         const char* what) const {
  const double value = value_of(number(n)), rounded = std::round(value);
  if (std::abs(value - rounded) > 1e-9 || std::abs(value) > 1e6)
    throw SpecError(pointer, fmt::format("{:g}", value), fmt::format("{} is a whole number", what));
  return static_cast<long>(rounded);
}

template <class S>
ItemSource Flattener<S>::source_of(const DesignItem& item) const {
  std::string instance = scope_.instance;
  if (!copy_.empty()) {
    std::vector<std::string> indices;
    for (const auto& [name, value] : copy_) indices.push_back(fmt::format("{} = {}", name, value));
    instance += fmt::format(" (copy {})", fmt::join(indices, ", "));
  }
  return {&plan_.source, item.pointer, std::move(instance), scope_.part};
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
    const DesignNumber& inside = item.braces.at(text.substr(at + 1, end - at - 1));
    name += std::to_string(whole(inside, inside.formula->pointer(), "a number in braces"));
    at = end;
  }
  return name;
}

template <class S>
NamedBody Flattener<S>::named(const DesignItem& item, const std::string& name,
                              const std::string& key) const {
  const std::string wanted = instance_name(item, name);
  if (const auto found = bodies_.find(wanted); found != bodies_.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [own, index] : bodies_) known.push_back(own);
  throw SpecError(item.pointer + key, "\"" + wanted + "\"",
                  "there is no such body; " + known_names(wanted, known));
}

template <class S>
int Flattener<S>::body(const DesignItem& item, const std::string& name, const char* key) const {
  const NamedBody found = named(item, name, key);
  if (found.body == no_body)
    throw SpecError(item.pointer + key, "\"" + instance_name(item, name) + "\"",
                    "all interfaces of this elastic body are parts of other bodies: name one of "
                    "those, or one of its interfaces");
  return found.body;
}

template <class S>
template <class Item, class Add>
void Flattener<S>::each_copy(const Item& item, std::size_t index, Add add) {
  if (index == item.repeat.size()) {
    attempt(item, [&] { add(item); });
    return;
  }
  const RepeatIndex& repeat = item.repeat[index];
  const std::string pointer = item.pointer + "/repeat/" + repeat.name;
  long first = 0, last = -1;
  const bool sound = attempt(item, [&] {
    first = whole(repeat.first, pointer, "an index");
    last = whole(repeat.last, pointer, "an index");
    if (last - first + 1 > most_copies)
      throw SpecError(pointer, fmt::format("{} copies", last - first + 1),
                      fmt::format("at most {} copies", most_copies));
  });
  if (!sound) last = first - 1;
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
  return std::ranges::all_of(plan_.let_numbers, [&](const DesignNumber& own) {
    return attempt(DesignItem{}, [&] { slots_.push_back(number(own)); });
  });
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
    const ItemSource at{&plan_.source, pointer, scope_.instance, scope_.part};
    faults_.add(located(at, SpecError(pointer, value,
                                      fmt::format("{} ({})", with_values(rule.otherwise, values),
                                                  rule.that.text()))));
  }
}

// Whether a number depends on constants and indices alone, not on parameters or lets. Slots of
// indices come after those of parameters and lets.
template <class S>
bool Flattener<S>::is_fixed(const DesignNumber& n) const {
  const auto first = static_cast<int>(plan_.parameters.size() + plan_.lets.size());
  return !n.formula ||
         std::ranges::all_of(n.formula->slots(), [&](int slot) { return slot >= first; });
}

template <class S>
void Flattener<S>::collect_frames() {
  each(plan_.frames, [&](const FrameItem& item) {
    const std::string name = instance_name(item, item.name);
    if (!frames_.try_emplace(name, Frame{&item, slots_, copy_}).second)
      throw SpecError(item.pointer + "/name", "\"" + name + "\"", "another frame has this name");
  });
  for (const auto& [name, frame] : frames_)
    attempt(*frame.item, [&, &name = name, &frame = frame] { this->frame(name, *frame.item); });
}

template <class S>
Placement<S> Flattener<S>::frame(const std::string& name, const DesignItem& item, const char* key) {
  if (name.empty()) return scope_.placement;
  const std::string wanted = instance_name(item, name);
  const auto found = frames_.find(wanted);
  if (found == frames_.end()) {
    std::vector<std::string> known;
    for (const auto& [own, frame] : frames_) known.push_back(own);
    throw SpecError(item.pointer + key, "\"" + wanted + "\"",
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
    const Placement<S> outer = frame(own.frame, own, "/in");
    Matrix3<S> turned = Matrix3<S>::Identity();
    for (const FrameItem::Turn& turn : own.turns)
      turned = Matrix3<S>(turned.lazyProduct(turn_about<S>(turn.axis, number(turn.angle))));
    Placement<S> result = outer.inside(vector(own.at), turned, false);
    for (const FrameItem::Turn& turn : own.turns) result.fixed &= is_fixed(turn.angle);
    restore();
    return result;
  } catch (...) {
    restore();
    throw;
  }
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
  FamilyChoices choices = item.choices;
  if (const auto own = input_.choices->find(elastic_bodies_option);
      own != input_.choices->end() && own->second == "rigid" && choices.contains(own->first))
    choices[own->first] = own->second;
  input.choices = &choices;
  input.material = input_.material;
  typename Flattener::Scope scope;
  scope.placement = frame(item.frame, item);
  if (item.mirror >= 0) {
    Matrix3<S> reflection = Matrix3<S>::Identity();
    reflection(item.mirror, item.mirror) = S(-1);
    scope.placement = scope.placement.inside(Vector3<S>(S(0), S(0), S(0)), reflection, true);
  }
  scope.prefix = scope_.prefix + name + "/";
  scope.part = std::make_shared<const ItemSource>(source_of(item));
  scope.instance = scope.part->instance + " (part " + scope_.prefix + name + ")";
  for (const auto& [inner, outer] : item.join) {
    const std::string joined = instance_name(item, inner);
    const auto known = [&](const BodyItem& own) { return own.name == joined; };
    if (joined != "ground" && std::ranges::none_of(item.design->bodies, known))
      throw SpecError(item.pointer + "/join", "\"" + joined + "\"", "the part has no such body");
    scope.joined[joined] = named(item, outer, "/join");
  }
  FaultList faults;
  const auto inner = Flattener(*item.design, input, std::move(scope), out_, faults).run();
  if (!faults.faults().empty()) throw SpecError(faults.faults());
  for (const auto& [own, index] : inner)
    if (own != "ground") bodies_[fmt::format("{}/{}", name, own)] = index;
}

template <class S>
NamedBodies Flattener<S>::run() {
  bodies_ = scope_.joined;
  bodies_.try_emplace("ground");
  if (!take_numbers()) return bodies_;
  check_rules();
  collect_frames();
  each(plan_.bodies, [&](const BodyItem& item) { add_body(item); });
  each(plan_.parts, [&](const PartItem& item) { add_part(item); });
  each(plan_.bodies, [&](const BodyItem& item) { tie_interfaces(item); });
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

template class Flattener<double>;
template class Flattener<Dual1>;

template <class S>
FlatDesign<S> flatten(const DesignPlan& plan, const DesignInput<S>& input, FaultList& faults) {
  FlatDesign<S> design;
  Flattener<S>(plan, input, {}, design, faults).run();
  return design;
}

template <class S>
FlatDesign<S> flatten(const DesignPlan& plan, const DesignInput<S>& input) {
  FaultList faults;
  FlatDesign<S> design = flatten(plan, input, faults);
  faults.raise();
  return design;
}

template FlatDesign<double> flatten(const DesignPlan&, const DesignInput<double>&, FaultList&);
template FlatDesign<double> flatten(const DesignPlan&, const DesignInput<double>&);
template FlatDesign<Dual1> flatten(const DesignPlan&, const DesignInput<Dual1>&);

}  // namespace flexopt
