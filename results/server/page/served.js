// Pages that a server of flexopt gives out: the report, and beside it what is moved or watched.
import {about} from "./calls.js";
import {explore} from "./explore.js";
import {watch} from "./watch.js";

({explore, watch})[about.kind](document.getElementById("live"));
