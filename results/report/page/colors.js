// Colours that people with the common kinds of colour blindness can tell apart (Okabe and Ito).
import {interpolateViridis} from "d3";

export const palette = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#8c8c8c", "#b8a800"];

export const direction_colors = {
  ux: "#0072b2", uy: "#e69f00", uz: "#d55e00", rx: "#009e73", ry: "#56b4e9", rz: "#cc79a7",
  x: "#0072b2", y: "#e69f00", z: "#d55e00",
};

export const kind_colors = {
  drive: "#8c8c8c", end_effector: "#0072b2", intermediate_body: "#cc79a7", leaf: "#e69f00",
};

/// Share 0 … 1 of the largest stress.
export const stress_color = interpolateViridis;

/// A colour of the page's style sheet, which follows light and dark.
export const page_color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const dark_mode = matchMedia("(prefers-color-scheme: dark)");
