// Sliders for the numbers of a design. Each move is evaluated by the server; of moves that come
// while one is under way the newest follows.
import {about, ask, gone} from "./calls.js";
import {element, number_text, quantity_text, readable, shown_factor, shown_unit} from "../../report/page/text.js";

const steps = 1000;

/// One number: a slider, and a box for the number itself.
function control(slider, change) {
  const {min, max, unit, whole} = slider, factor = shown_factor(unit), id = `move-${slider.name}`;
  const inside = (x) => Math.min(max, Math.max(min, whole ? Math.round(x) : x));
  const range = element("input", {type: "range", id, min: 0, max: whole ? max - min : steps, step: 1, title: slider.meaning,
    oninput: () => set(whole ? min + Number(range.value) : range.value === range.max ? max : min + (max - min) * range.value / steps, true)});
  const box = element("input", {type: "number", step: "any", min: min * factor, max: max * factor, "aria-label": `${readable(slider.name)}${unit === "1" ? "" : ` in ${shown_unit(unit)}`}`,
    onchange: () => { const x = Number(box.value) / factor; set(box.value !== "" && Number.isFinite(x) ? inside(x) : one.value, true); }});
  const place = element("div", {class: "move"}, element("label", {for: id, title: slider.meaning}, readable(slider.name)), box,
    element("span", {class: "soft"}, shown_unit(unit)), range);
  function set(value, tell = false) {
    one.value = value;
    range.value = whole ? value - min : Math.round(steps * (value - min) / (max - min));
    box.value = Number((value * factor).toPrecision(6));
    range.setAttribute("aria-valuetext", quantity_text(value, unit, 4));
    place.classList.toggle("moved", value !== slider.value);
    if (tell) change();
  }
  const one = {name: slider.name, value: slider.value, place, set, reset: () => set(slider.value)};
  one.reset();
  return one;
}

const goal_text = (goal, value) => value === null ? "–" : goal.unit === "SI" ? number_text(value, 4) : quantity_text(value, goal.unit, 4);

/// Objective and constraints with value and bound, and what they were of the job's own design.
function goal_table(goals, first) {
  const bound = (goal) => goal.role === "objective" ? `${goal.sense}d`
    : [goal.min === null ? null : `≥ ${goal_text(goal, goal.min)}`, goal.max === null ? null : `≤ ${goal_text(goal, goal.max)}`].filter(Boolean).join(", ");
  const row = (goal, k) => element("tr", {},
    element("td", {}, goal.unit === "SI" ? goal.label : readable(goal.label), goal.as ? element("small", {class: "soft"}, " without tolerances") : null),
    element("td", {class: goal.role === "objective" ? "" : goal.met ? "good" : "bad"}, goal_text(goal, goal.value), element("br"), element("small", {}, goal.role === "objective" ? bound(goal) : `${goal.met ? "keeps" : "misses"} ${bound(goal)}`)),
    element("td", {class: "soft"}, first?.[k] ? goal_text(first[k], first[k].value) : "–"));
  return element("table", {class: "goals", id: "goals"},
    element("thead", {}, element("tr", {}, ...["Goal", "Here", "Job's design"].map((text) => element("th", {scope: "col"}, text)))),
    element("tbody", {}, ...goals.map(row)));
}

export function explore(panel) {
  const say = element("p", {id: "say", role: "status", class: "soft"}), goals = element("div", {});
  const log = window.flexopt_explore = {answered: 0, failed: 0, dropped: 0, times: []};  // for tests
  let running = false, waiting = false, first = null;
  const controls = about.sliders.map((slider) => control(slider, () => move()));
  const parameters = () => Object.fromEntries(controls.map((c) => [c.name, c.value]));
  const tell = (text, tone = "soft") => { say.textContent = text; say.className = tone; };

  async function evaluate(begun) {
    const patience = setTimeout(() => tell("Evaluating …"), 500);
    const response = await ask("/evaluate", {parameters: parameters()});
    clearTimeout(patience);
    if (!response) { tell(gone, "bad"); return; }
    if (!response.ok) { tell(await response.text(), "bad"); log.failed += 1; return; }
    const answer = await response.json();
    document.body.classList.toggle("stale", !answer.ok);
    if (!answer.ok) {
      tell(`${answer.message}\nShown is the last design that could be evaluated.`, "bad");
      log.failed += 1;
      return;
    }
    const everything = window.flexopt_report.show(answer.result, answer.scene);
    const pictured = performance.now() - begun;
    first ??= answer.goals;
    goals.replaceChildren(...(answer.goals.length > 0 ? [goal_table(answer.goals, first)] : []));
    tell(`Evaluated in ${number_text(1e3 * answer.seconds, 2)} ms${about.full ? " at full accuracy" : ""}.`);
    await everything;
    log.times.push({picture: pictured, everything: performance.now() - begun, evaluation: 1e3 * answer.seconds});
    log.answered += 1;
  }

  /// Evaluates where nothing runs; else the newest numbers are evaluated when that is done.
  async function move() {
    if (running) { log.dropped += waiting ? 1 : 0; waiting = true; return; }
    running = true;
    do {
      waiting = false;
      await evaluate(performance.now());
    } while (waiting);
    running = false;
  }

  const back = element("button", {type: "button", id: "back", onclick: () => { for (const c of controls) c.reset(); move(); }}, "Back to the job's design");
  const write = element("button", {type: "button", id: "write", onclick: async () => {
    const response = await ask("/job", {parameters: parameters()});
    if (!response?.ok) { tell(response ? await response.text() : gone, "bad"); return; }
    const url = URL.createObjectURL(await response.blob()), name = about.name.replace(/[^\w-]+/g, "_").replace(/^_+|_+$/g, "") || "job";
    element("a", {href: url, download: `${name}.json`}).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
  }}, "Write job file");
  panel.append(element("h2", {}, `Explore: ${about.name}`), element("fieldset", {}, ...controls.map((c) => c.place)),
    element("div", {class: "controls"}, back, write), say, goals);
  move();
}
