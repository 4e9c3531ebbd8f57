// What the parts of the page share: the stroke that is shown, the mode, the chosen leaf. Whoever
// changes a value calls set(); whoever shows one listens.
let listeners = [];

export const state = {
  stroke: 0,      // SI; with named drives the place in the path
  mode: null,     // {drive: "locked" | "free", index}, or null
  leaf: null,     // name of the chosen leaf
  beside: null,   // place in the scene's list of the design at the side
  playing: false,
  phase: 0,       // phase of the mode's animation [rad]
  load_case: null,  // name of one that the reader chose, where the job has several
};

/// set({stroke: 0.1}): changes the state and tells the listeners what is new.
export function set(changes) {
  const fresh = {};
  for (const [key, value] of Object.entries(changes))
    if (state[key] !== value) { state[key] = value; fresh[key] = value; }
  if (Object.keys(fresh).length > 0) for (const {keys, act} of listeners)
    if (keys.some((key) => key in fresh)) act(state);
}

/// Calls act(state) whenever one of these keys changes.
export const listen = (keys, act) => listeners.push({keys, act});

/// Forgets who listens: before the page is drawn anew.
export const forget_listeners = () => { listeners = []; };
