// Follows a run: asks for news, and shows them as they come.
import {about, ask, gone} from "./calls.js";
import {element, number_text, quantity_text, readable} from "../../report/page/text.js";

const pause = 1000;  // between questions [ms]
const quiet = 60;    // seconds without news after which the run may have stopped

const ago = (seconds) => seconds < 1.5 ? "just now" : seconds < 90 ? `${Math.round(seconds)} s ago` : seconds < 5400 ? `${Math.round(seconds / 60)} min ago` : `${number_text(seconds / 3600, 2)} h ago`;

export function watch(panel) {
  const say = element("p", {id: "say", role: "status"}, "Looking …"), when = element("p", {class: "soft", id: "when"}), facts = element("div", {});
  const follow = element("input", {type: "checkbox", id: "follow", checked: true});
  panel.append(element("h2", {}, `Watch: ${about.name}`), say, when, facts, element("label", {class: "choice"}, follow, "follow the run"));
  const log = window.flexopt_watch = {shown: 0, finished: false, evaluations: 0};  // for tests
  let version = "";

  function show_facts(result) {
    const optimum = result.optimum, constraints = optimum?.constraints ?? [];
    const worst = constraints.length > 0 ? constraints.reduce((a, b) => b.margin / (Math.abs(b.bound) || 1) < a.margin / (Math.abs(a.bound) || 1) ? b : a) : null;
    const rows = optimum ? [["Evaluations", `${optimum.evaluations} (${optimum.failed_evaluations} failed)`],
      ["Best so far", typeof optimum.objective !== "number" ? "none yet" : optimum.goal.unit === "SI" ? number_text(optimum.objective, 5) : quantity_text(optimum.objective, optimum.goal.unit, 5)],
      worst ? ["Worst constraint", `${readable(worst.label)}: ${worst.active ? "at its bound" : `${worst.margin < 0 ? "violated by" : "margin"} ${number_text(100 * Math.abs(worst.margin / (worst.bound || 1)), 2)} %`}`] : null] : [];
    facts.replaceChildren(element("dl", {class: "facts", id: "facts"}, ...rows.filter(Boolean).map(([name, text]) => element("div", {}, element("dt", {}, name), element("dd", {}, text)))));
  }

  /// True while there may be more to come.
  async function look() {
    const response = await ask("/state", {since: version});
    if (!response) { say.textContent = gone; return false; }
    if (!response.ok) { say.textContent = await response.text(); return true; }
    const news = await response.json();
    when.textContent = news.age === null ? "" : `Last written ${ago(news.age)}.${!log.finished && news.age > quiet ? " The run is busy with something long, or was interrupted." : ""}`;
    if (news.unchanged) return true;
    if (news.waiting) { say.textContent = `Nothing to show yet. ${news.waiting}`; version = news.version; return true; }
    version = news.version;
    log.finished = news.finished;
    say.textContent = news.finished ? "The run is finished." : "The run goes on.";
    show_facts(news.result);
    await window.flexopt_report.show(news.result, news.scene);
    log.evaluations = news.result.optimum?.evaluations ?? 0;  // once they are drawn
    log.shown += 1;
    return true;
  }

  (async () => {
    for (let go_on = true; go_on;) {
      if (follow.checked) go_on = await look();
      await new Promise((done) => setTimeout(done, pause));
    }
  })();
}
