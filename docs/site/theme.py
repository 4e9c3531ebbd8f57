"""What Debian's package of the theme leaves to a web server or to a button, for pages opened as files."""
import pathlib
import re
import shutil

NORMALIZE = "/javascript/normalize.css/normalize.css"


def complete(static):
    """Puts normalize.css beside the style sheet that asks a server for it, makes one script of two
    modules, which browsers do not load from files, and gives the dark colours to whoever prefers them.
    A theme that has all this stays as it is."""
    style = static / "styles/furo.css"
    text = style.read_text()
    if NORMALIZE in text:
        shutil.copyfile(pathlib.Path("/usr/share") / NORMALIZE.lstrip("/"), style.with_name("normalize.css"))
        text = text.replace(NORMALIZE, "normalize.css")
    if "prefers-color-scheme" not in text:
        colours = re.search(r'body\[data-theme="dark"\] (\{[^}]*\})', text)[1]
        text += ("@media not print { @media (prefers-color-scheme: dark) {\n"
                 f'body:not([data-theme="light"]) {colours}\n}} }}\n')
    style.write_text(text)
    script = static / "scripts/furo.js"
    code = script.read_text()
    module = re.match(r'import \w+ from "\./([\w.-]+)";\n', code)
    if module:
        script.write_text((script.parent / module[1]).read_text() + "\n" + code[module.end():])
