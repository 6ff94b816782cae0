"""Checks how the repository is written: the order of the rooms, layout, lengths, and references in comments.

    style_check.py ROOT [--no-layout]

Prints one line for each fault (file, line, what is wrong) and exits with 1 if there is one. Checked are

- room order: a file includes its own room and those below it (README.md, Rooms);
- floors: within a room whose README has a table of floors, a file includes none of a floor above its own;
- layout: `clang-format --dry-run` changes nothing (left out with --no-layout, or, with a note, where clang-format is missing);
- lengths: no line over 125 columns, no source file over 400 lines, no function over 60 unless its first line is a comment that
  says why ("This is one function because ..."), and none with more than 6 parameters unless that line says why ("It has so many
  parameters because ...");
- rules: a comment that cites "watertightness rule N" names a rule that docs/watertightness.md has;
- errors: those without a file are made by error_without_file();
- references: a file that a comment or a page names exists, and so does a symbol in backticks in a comment of the sources;
- tables: each row of a page is in a table, and has as many columns as its table.
"""
import pathlib
import re
import shutil
import subprocess
import sys

# Lowest first; a room may include what stands before it, less what FORBIDDEN says.
ROOMS = ["base", "scenegraph", "io", "lod", "accel", "shade", "render", "verify", "api", "command"]
FORBIDDEN = {("shade", "accel"), ("verify", "shade"), ("verify", "render")}
MAY_USE = {
    room: {below for below in ROOMS[:place] if (room, below) not in FORBIDDEN}
    for place, room in enumerate(ROOMS)
}
MAX_COLUMNS = 125
MAX_LINES = 400
MAX_FUNCTION_LINES = 60
MAX_PARAMETERS = 6
WHY_LONG = "// This is one function because "
WHY_MANY = "// It has so many parameters because "

FILE_NAME = re.compile(r"(?<![\w./<\"*-])((?:[\w-]+/)*[\w-]+\.(?:h|cpp|md|py|cmake|sh))(?![\w])")
FLOOR = re.compile(r"^\| (\d) \| [^|]+ \| ([\w, ]+) \|$")
RULE = re.compile(r"watertightness(?:\.md)?,? rules? (\d+)(?:(?:,| and| to|, and) (\d+))*")
TABLE_RULE = re.compile(r"\|(?:-+\|)+")
SYMBOL = re.compile(r"`([A-Za-z_][\w:]*(?:\(\))?)`")

# A name with an opening bracket, what follows the parameters of a definition, and a first parameter: a type and a name.
CALL = re.compile(r"\b(?!(?:if|for|while|switch|return|catch)\b)([A-Za-z_]\w*)\(")
BODY = re.compile(r"\s*(?:const|noexcept|override|final|\s)*(?:->[^{;=]*)?(?:\{|\n\s*: )")
TYPED = re.compile(r"\s*(?:const )?[A-Za-z_][\w:]*(?:<[^()]*>)?(?: const)?[\s&*]+(?:\(&)?\w+")


def sources(root: pathlib.Path) -> list[pathlib.Path]:
    """Returns all C++ files below the rooms, tests/ and samples/."""
    folders = ROOMS + ["tests", "samples"]
    return sorted(p for f in folders for p in (root / f).rglob("*") if p.suffix in {".h", ".cpp"})


def comment_of(line: str) -> str:
    """Returns the comment of a line of C++, or nothing. A "//" within a string counts as a comment; it does no harm here."""
    at = line.find("//")
    return line[at:] if at >= 0 else ""


class Check:
    def __init__(self, root: pathlib.Path):
        self.root = root
        self.faults: list[str] = []
        self.files = sources(root)
        self.lines = {p: p.read_text().splitlines() for p in self.files}
        self.names = {p.name for p in root.rglob("*") if p.is_file() and not self.is_outside(p)}
        text = (root / "docs/watertightness.md").read_text()
        self.rules = {int(n) for n in re.findall(r"^\| (\d+) \|", text, re.M)}
        code = (line.split("//")[0] for lines in self.lines.values() for line in lines)
        self.words = set(re.findall(r"\w+", "\n".join(code)))

    def is_outside(self, path: pathlib.Path) -> bool:
        top = path.relative_to(self.root).parts[0]
        return top in {"build", ".git"}

    def fault(self, path: pathlib.Path, number: int, what: str) -> None:
        self.faults.append(f"{path.relative_to(self.root)}:{number}: {what}")

    def room_order(self) -> int:
        includes = 0
        for path, lines in self.lines.items():
            room = path.relative_to(self.root).parts[0]
            if room not in MAY_USE:
                continue
            for number, line in enumerate(lines, 1):
                found = re.match(r'\s*#\s*include\s*"(\w+)/', line)
                if not found or found.group(1) not in MAY_USE:
                    continue
                includes += 1
                if found.group(1) != room and found.group(1) not in MAY_USE[room]:
                    self.fault(path, number, f"{room} may not include {found.group(1)}")
        if includes == 0:
            self.faults.append("no include between rooms was found: the check itself is broken")
        return includes

    def floors(self) -> None:
        """A room whose README has a table of floors includes nothing of a floor above. Each file is on one floor."""
        for room in ROOMS:
            readme = self.root / room / "README.md"
            floor_of = {}
            for number, row in enumerate(readme.read_text().splitlines() if readme.exists() else [], 1):
                found = FLOOR.match(row)
                for name in found.group(2).split(", ") if found else []:
                    if name in floor_of or not any((self.root / room / (name + end)).exists() for end in (".h", ".cpp")):
                        self.fault(readme, number, f"{name} is on another floor, too, or does not exist")
                    floor_of[name] = int(found.group(1))
            for path, lines in self.lines.items() if floor_of else []:
                if path.parent != self.root / room:
                    continue
                if path.stem not in floor_of:
                    self.fault(path, 1, f"{room}/README.md has it on no floor")
                for number, line in enumerate(lines, 1):
                    found = re.match(rf'#include "{room}/(\w+)\.h"', line)
                    if found and floor_of.get(found.group(1), 0) > floor_of.get(path.stem, 0):
                        self.fault(path, number, f"{found.group(1)}.h is on a floor above this file's")

    def functions(self) -> None:
        """Measures what stands between a line that is "{" alone, as clang-format begins functions, and the "}" below it."""
        for path, lines in self.lines.items():
            for at, line in enumerate(lines):
                if line.strip() != "{":
                    continue
                end = line.replace("{", "}")
                last = next((i for i in range(at + 1, len(lines)) if lines[i].startswith(end)), len(lines))
                if last - at - 1 > MAX_FUNCTION_LINES and not lines[at + 1].strip().startswith(WHY_LONG):
                    self.fault(path, at + 1, f"the function has more than {MAX_FUNCTION_LINES} lines and does not say why")

    def parameters(self) -> None:
        """Counts the parameters of functions where they are defined, and of constructors."""
        for path, lines in self.lines.items():
            text = "\n".join(line.split("//")[0] for line in lines)
            for found in CALL.finditer(text):
                depth, count, angles, at = 1, 1, 0, found.end()
                while depth > 0 and at < len(text):
                    c = text[at]
                    depth += (c in "([{") - (c in ")]}")
                    angles += (c == "<") - (c == ">" and text[at - 1] != "-")
                    count += c == "," and depth == 1 and angles == 0
                    at += 1
                inside = text[found.end():at - 1]
                if count > MAX_PARAMETERS and BODY.match(text, at) and TYPED.match(inside):
                    if lines[text.count("\n", 0, at) + 2].strip().startswith(WHY_MANY):
                        continue
                    number = text.count("\n", 0, found.start(1)) + 1
                    self.fault(path, number, f"{found.group(1)} has {count} parameters, more than {MAX_PARAMETERS}")

    def lengths(self) -> None:
        for path, lines in self.lines.items():
            if len(lines) > MAX_LINES:
                self.fault(path, len(lines), f"the file has more than {MAX_LINES} lines")
            for number, line in enumerate(lines, 1):
                if len(line) > MAX_COLUMNS:
                    self.fault(path, number, f"the line has more than {MAX_COLUMNS} columns")

    def exists(self, name: str, beside: pathlib.Path) -> bool:
        if "/" not in name:
            return name in self.names
        starts = [self.root, beside, self.root / "api/include", self.root / "io", self.root / "scenegraph", self.root / "tests"]
        return any((start / name).exists() for start in starts)

    def check_text(self, path: pathlib.Path, number: int, text: str) -> None:
        for name in FILE_NAME.findall(text):
            if not self.exists(name, path.parent):
                self.fault(path, number, f"names the file {name}, which does not exist")
        if "watertightness" in text:
            for rule in RULE.finditer(text):
                for cited in re.findall(r"\d+", rule.group(0)):
                    if int(cited) not in self.rules:
                        self.fault(path, number, f"cites watertightness rule {cited}, which does not exist")

    def references(self) -> None:
        for path, lines in self.lines.items():
            for number, line in enumerate(lines, 1):
                comment = comment_of(line)
                if not comment:
                    continue
                self.check_text(path, number, comment)
                for symbol in SYMBOL.findall(comment):
                    last = symbol.removesuffix("()").split("::")[-1]
                    if last not in self.words:
                        self.fault(path, number, f"names `{symbol}`, which no source file has")
        for path in self.pages():
            for number, line in enumerate(path.read_text().splitlines(), 1):
                self.check_text(path, number, line)

    def tables(self) -> None:
        """A row that begins a table has the line below it that makes it one, and all rows have as many columns."""
        for path in self.pages():
            columns = 0
            lines = path.read_text().splitlines() + [""]
            for number, line in enumerate(lines[:-1], 1):
                is_row = line.startswith("|")
                if is_row and columns == 0 and not TABLE_RULE.fullmatch(lines[number]):
                    self.fault(path, number, "the row is in no table: there is no |---| below it")
                elif is_row and columns not in (0, line.count("|")):
                    self.fault(path, number, "the row has not as many columns as its table")
                columns = line.count("|") if is_row else 0

    def pages(self) -> list[pathlib.Path]:
        return [path for path in sorted(self.root.rglob("*.md")) if not self.is_outside(path)]

    def errors(self) -> None:
        """An error that no file is to blame for is made in one way."""
        for path, lines in self.lines.items():
            if path.relative_to(self.root).parts[0] not in MAY_USE:
                continue
            for number, line in enumerate(lines, 1):
                if re.search(r'\bError\(""', line):
                    self.fault(path, number, "error_without_file() makes an error without a file")

    def layout(self) -> None:
        program = shutil.which("clang-format") or shutil.which("clang-format-14")
        if not program:
            print("layout is not checked: clang-format is not installed")
            return
        ran = subprocess.run([program, "--dry-run", "--ferror-limit=1", *map(str, self.files)],
                             capture_output=True, text=True, check=False)
        for line in ran.stderr.splitlines():
            found = re.match(r"(.+):(\d+):\d+: warning: code should be clang-formatted", line)
            if found:
                self.fault(pathlib.Path(found.group(1)), int(found.group(2)), "clang-format would change this line")


def main() -> int:
    check = Check(pathlib.Path(sys.argv[1]).resolve())
    includes = check.room_order()
    check.lengths()
    check.floors()
    check.functions()
    check.parameters()
    check.references()
    check.tables()
    check.errors()
    if "--no-layout" not in sys.argv[2:]:
        check.layout()
    print("\n".join(check.faults))
    print(f"{len(check.files)} files, {includes} includes between rooms, {len(check.faults)} faults")
    return 1 if check.faults else 0


sys.exit(main())
