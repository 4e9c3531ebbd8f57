// Requests to the server that gave this page out.
export const about = JSON.parse(document.getElementById("about").textContent);
const token = new URLSearchParams(location.search).get("token") ?? "";

/// The answer to a POST, whatever its status; null where the server does not answer.
export async function ask(path, body) {
  try {
    return await fetch(path, {method: "POST", body: JSON.stringify(body), headers: {"X-Flexopt-Token": token}, cache: "no-store"});
  } catch {
    return null;
  }
}

export const gone = "flexopt does not answer any more: it was closed. The page stays as it is.";
