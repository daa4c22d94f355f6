"""What the command can do, Python can: the command's own help is walked, and what has no counterpart must be named here."""

import ast
import inspect
import re
import subprocess
from pathlib import Path

import pytest

import terra

#: Commands that Python has none of, and why. What the help hides (`pages`, which makes pages of the book) is not asked for.
NO_COMMAND = {
    "completions": "of a shell",
    "man": "of a shell; Python has help()",
    "help": "Python has help()",
}
#: Options that Python has none of, wherever they stand, and why.
NO_OPTION = {
    "quiet": "nothing is displayed",
    "threads": "RAYON_NUM_THREADS in the environment, before the first call",
    "help": "Python has help()",
    "version": "terra.__version__",
    "json": "what the function returns",
    "csv": "what the function returns",
}
#: What the command calls otherwise, wherever it stands.
RENAMED = {"radius_m": "radius", "width_m": "width", "load_n": "normal_load", "value": "values", "no_refine": "refine"}

RETURNED = "what the function returns"
#: The functions of every command, and of its arguments and options by their own name: the parameter that has another name
#: here, or why there is none.
COMMANDS = {
    "demo": ([terra.demo], {}),
    "models": ([terra.models], {}),
    "effects": ([terra.effects], {}),
    "terrains": ([terra.terrains], {}),
    "filters": ([terra.filters], {}),
    "estimators": ([terra.estimators], {}),
    "wheel": ([terra.wheel], {}),
    "bevameter": ([terra.bevameter], {}),
    "inspect": ([terra.inspect], {}),
    "init": ([terra.init], {"class": "robot"}),
    "cite": ([terra.cite], {}),
    "simulate": (
        [terra.simulate],
        {"out": RETURNED, "truth": RETURNED, "list": terra.scenario_effects},
    ),
    "estimate": ([terra.estimate], {"out": RETURNED}),
    "identify": ([terra.identify], {}),
    "identifiability": ([terra.identifiability], {}),
    "gap": ([terra.gap, terra.watch], {"watch": terra.watch, "track": RETURNED}),
    "import": ([terra.import_log, terra.import_scm_json], {}),
    "export scm-json": ([terra.scm_json], {"out": RETURNED}),
    "export slip-compliance": ([terra.slip_compliance], {"out": RETURNED}),
    "campaign ramps": ([terra.campaign.ramps], {}),
    "campaign faults": ([terra.campaign.faults], {}),
    "campaign reproduction": ([terra.campaign.reproduction], {}),
    "campaign gap": ([terra.campaign.gap], {}),
    "campaign cross-structure": ([terra.campaign.cross_structure], {}),
    "campaign gap-calibration": ([terra.campaign.gap_calibration], {}),
    "challenge make": ([terra.challenge.make], {}),
    "challenge run": ([terra.challenge.run], {}),
    "challenge score": ([terra.challenge.score], {"skip_closing": "closing"}),
    "challenge reveal": ([terra.challenge.reveal], {}),
    "sweep": ([terra.sweep], {}),
    "merge": ([terra.merge], {}),
}
#: Parameters whose default is another than the command's, and why.
OTHER_DEFAULT = {
    ("init", "out"): "without a file the text alone is returned",
    ("gap", "effects"): "None is all",
    ("identifiability", "noise"): "None is the same: a dict is no default",
}


def name(text):
    """`--load_N <W>`, `[SCENARIO]`, `<LOG>...` to `load_n`, `scenario`, `log`."""
    return re.search(r"[A-Za-z][\w-]*", text).group().lower().replace("-", "_")


def sections(text):
    """Entries under each heading of a help text: what is to the left, and all that is said of it."""
    found, heading = {}, None
    for line in text.splitlines():
        if re.fullmatch(r"[A-Z]\w+:", line):
            heading = found.setdefault(line[:-1], [])
        elif heading is not None and (entry := re.match(r" {2,6}(\S.*?)(?: {2,}(.*))?$", line)):
            heading.append([entry[1], entry[2] or ""])
        elif heading and line.strip():
            heading[-1][1] += " " + line.strip()
    return found


def walk(command, *path):
    """Every command that does something, with its arguments and options and the defaults they have."""
    help = sections(command(*path, "-h"))
    if "Commands" in help:
        for entry, _ in help["Commands"]:
            if entry not in NO_COMMAND:
                yield from walk(command, *path, entry)
        return
    asked = {}
    for entry, said in help.get("Arguments", []) + help["Options"]:
        default = re.search(r"\[default: (.*?)\]", said)
        # `-h, --help` by its long name.
        asked[name(entry.split(", ")[-1])] = default and default[1]
    yield " ".join(path), asked


@pytest.fixture(scope="module")
def all_commands(command):
    return dict(walk(command))


def test_every_command_has_its_functions(all_commands):
    assert len(all_commands) > 25, "the help is read as it is written"
    assert set(all_commands) == set(COMMANDS)


def counterpart(command, option):
    """The parameter of an option, why there is none, or None."""
    functions, own = COMMANDS[command]
    named = own.get(option, RENAMED.get(option, option))
    if not isinstance(named, str) or " " in named:
        return named
    for function in functions:
        parameters = inspect.signature(function).parameters
        # A list has the plural: `--terrain` once is `terrain`, many `<LOG>...` of one call are `log`.
        for spelled in (named, named + "s"):
            if spelled in parameters:
                return parameters[spelled]
    return NO_OPTION.get(option)


def test_every_option_has_its_parameter(all_commands):
    missing = [
        f"{command} --{option}"
        for command, options in all_commands.items()
        for option in options
        if counterpart(command, option) is None
    ]
    assert not missing


#: A value that the command takes for what needs one.
VALUES = {"effects": "slip-sinkage", "soil": "own", "hold_out": "slip", "windows": "100", "baseline": "10", "false_alarms": "0.1"}


def test_a_watch_takes_what_its_flag_takes(all_commands, program):
    """`gap` and `watch` are two functions of one command: what it refuses beside --watch is `gap`'s alone, all else is in
    `watch` too, and what belongs to a watch is in no `gap`."""
    watch, gap = (set(inspect.signature(f).parameters) for f in (terra.watch, terra.gap))
    flags = {"same_bed", "motion_only"}
    taken = set()
    for option in set(all_commands["gap"]) - {"log", "rover", "watch", "help", *NO_OPTION}:
        flag = "--" + option.replace("_", "-")
        value = [] if option in flags else [VALUES.get(option, "1")]
        asked = [program, "gap", "no.csv", "--rover", "no.toml", flag, *value]
        said = [subprocess.run([*asked, *w], capture_output=True, text=True).stderr for w in ([], ["--watch"])]
        assert all("unexpected argument" not in s and "invalid value" not in s for s in said), (option, said)
        alone, beside = "--watch" not in said[0], "cannot be used with" not in said[1]
        if beside and option != "track":
            taken.add(option)
            assert option in watch, option
        # The same bed needs --sim.
        assert (option in gap) == (alone or option == "same_bed"), option
    assert taken == {"effects", "baseline", "false_alarms"}
    assert watch == taken | {"log", "rover", "registry"}


def test_nothing_is_named_that_is_gone(all_commands):
    """An entry of the tables above that the command does not have any more, or that Python has a parameter for."""
    everywhere = {option for options in all_commands.values() for option in options}
    assert set(NO_OPTION) - everywhere <= {"version"}
    assert set(RENAMED) <= everywhere
    for command, (functions, own) in COMMANDS.items():
        assert set(own) <= set(all_commands[command]), command
        for option, named in own.items():
            if named == RETURNED:
                assert all(option not in inspect.signature(f).parameters for f in functions), (command, option)


def written(value):
    """A default as the command writes it."""
    if isinstance(value, (list, tuple)):
        return ",".join(map(str, value))
    return str(value)


def same(text, value):
    try:
        return float(text) == float(written(value))
    except ValueError:
        return text == written(value)


def test_defaults_are_the_commands(all_commands):
    compared, other = 0, set()
    for command, options in all_commands.items():
        for option, default in options.items():
            parameter = counterpart(command, option)
            if default is None or not isinstance(parameter, inspect.Parameter):
                continue
            if same(default, parameter.default):
                compared += 1
            else:
                other.add((command, option))
    assert other == set(OTHER_DEFAULT)
    assert compared > 25


@pytest.mark.parametrize("module", [terra, terra.campaign, terra.challenge])
def test_all_that_is_public_is_documented(module):
    for public in module.__all__:
        thing = getattr(module, public)
        assert isinstance(thing, str) or inspect.getdoc(thing), public


def test_the_stubs_are_the_module():
    """Every function of the native half is in the stubs, with the same parameters in the same order."""
    stubs = Path(terra.__file__).with_name("_terra.pyi").read_text()
    said = {
        node.name: [a.arg for a in node.args.args]
        for node in ast.parse(stubs).body
        if isinstance(node, ast.FunctionDef)
    }
    native = {
        name: list(inspect.signature(thing).parameters)
        for name, thing in vars(terra._terra).items()
        if inspect.isbuiltin(thing)
    }
    assert said == native
