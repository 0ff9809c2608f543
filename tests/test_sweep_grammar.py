"""What both command lines share: hints, version, completion, and a reader that leaves."""

import argparse
import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import analysis
import kernel
import sweep as package
from analysis.cli import main as analysis_main
from analysis.cli import parser as analysis_parser
from kernel.hints import NAMES_MAX, SHOWN_MAX, did_you_mean, meant_or_known, shown
from kernel.quantities import QUANTITIES
from kernel.task import PARAMETERS
from sweep import cli, grammar
from sweep.plan.asked import Sought
from sweep.plan.sections import Accuracy
from sweep.plan.spec import Spec

BIN = Path(sys.executable).parent


@pytest.mark.parametrize(
    ("word", "choices", "meant"),
    [
        ("gird", ["name", "grid", "accuracy"], " (did you mean 'grid'?)"),
        ("n", ["N", "zeta_T"], " (did you mean 'N'?)"),
        ("spring.c9", ["spring.c2", "site"], " (did you mean 'spring.c2'?)"),
        ("spring.b", ["spring.c2", "site"], ""),
        ("bar", ["bwr", "brg", "gray"], ""),
        ("tolerance", ["name", "grid", "accuracy"], ""),
        ("V", ["M_over_M0", "V_over_V0"], " (did you mean 'V_over_V0'?)"),
        ("ke", ["ke_ratio", "ke_linear"], ""),
        ("", ["name"], ""),
        ("x", [], ""),
    ],
)
def test_a_mistyped_word_is_answered_with_what_looks_like_it_or_nothing(word, choices, meant):
    assert did_you_mean(word, choices) == meant


def test_names_and_values_are_shown_whole_as_long_as_they_are_not_too_many():
    names = [f"name{k}" for k in range(NAMES_MAX)]
    assert meant_or_known("q", names) == f" (there are {', '.join(names)})"
    assert meant_or_known("q", [*names, "last"]) == f" (there are {', '.join(names)}, ..)"
    value = "a" * (SHOWN_MAX - 2)  # without its quotes
    assert (shown(value), shown(value + "a")) == (f"'{value}'", f"'{value}a...")


NAMES = [*PARAMETERS, *QUANTITIES, *Spec.model_fields, *Sought.model_fields, *Accuracy.model_fields]


@settings(max_examples=300)
@given(st.sampled_from([name for name in NAMES if len(name) > 4]), st.data())
def test_a_name_with_one_slip_is_recognised(name, data):
    """A letter is missing, doubled or another one, or two are swapped."""
    k = data.draw(st.integers(0, len(name) - 2))
    before, one, two, after = name[:k], name[k], name[k + 1], name[k + 2 :]
    slip = data.draw(st.sampled_from([two, one + one + two, "x" + two, two + one]))
    word = before + slip + after
    assert did_you_mean(word, NAMES) == f" (did you mean {name!r}?)" or word in NAMES


@pytest.mark.parametrize("word", ["foo", "energy", "speed", "stress", "color", "width", "force", "velocity", "table"])
def test_a_word_that_is_no_slip_is_taken_for_none(word):
    assert did_you_mean(word, NAMES) == ""


@pytest.mark.parametrize(
    ("argv", "meant"),
    [
        (["pln", "x"], "'plan'"),
        (["run", "x", "--ouput", "y"], "--ouput (did you mean '--output'?)"),
        (["run", "x", "-o", "y", "--wrter=gather"], "--wrter (did you mean '--writer'?)"),
        (["show", "x", "--jsn"], "--jsn (did you mean '--json'?)"),
    ],
)
def test_a_mistyped_command_choice_or_option_is_answered_with_what_is_near_it(argv, meant, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(argv)
    assert caught.value.code == 2
    assert meant in capsys.readouterr().err.splitlines()[-1]


def test_a_mistyped_choice_of_a_run_is_answered_beside_what_is_wrong_with_its_spec(capsys):
    assert cli.main(["run", "none.toml", "-o", "y", "--writer", "gathr"]) == 2
    told = capsys.readouterr().err
    assert "--writer: invalid choice: 'gathr'" in told
    assert "did you mean 'gather'?" in told
    assert "none.toml" in told


def test_all_values_that_options_cannot_have_are_told_at_once(capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["run", "x", "--max-fails=-1", "--shard", "3/2", "--store", "", "--writer", "mpi", "--shart", "1/2"])
    assert caught.value.code == 2
    told = capsys.readouterr().err.splitlines()[-1]
    for one in ("--max-fails: must be a whole", "--shard: must be", "--store: must be the path of a folder, got ''"):
        assert one in told
    assert "(did you mean 'mpio'?); the following arguments are required: -o/--output; --shart (did you" in told


@pytest.mark.parametrize("grammar_of", [cli.parser, analysis_parser])
def test_the_help_of_a_command_says_what_it_does_and_what_each_argument_is(grammar_of):
    (names,) = (one for one in grammar_of()._actions if isinstance(one, argparse._SubParsersAction))
    told = {one.dest: one.help for one in names._choices_actions}
    for name, command in names.choices.items():
        assert told[name] in " ".join(command.format_help().split())
        assert all(one.help for one in command._actions if not one.option_strings), name


def test_a_shell_that_has_no_completion_is_refused_before_one_is_printed(capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["--print-completion", "fish"])
    assert caught.value.code == 2
    assert "invalid choice: 'fish'" in capsys.readouterr().err


def test_an_option_is_never_taken_for_another_that_begins_alike(capsys):
    with pytest.raises(SystemExit):
        cli.main(["show", "x", "--js"])
    assert "no such option or argument: --js" in capsys.readouterr().err


def test_all_three_packages_and_the_command_line_tell_the_installed_version(capsys):
    installed = metadata.version("bistable-sweep")
    assert {kernel.__version__, package.__version__, analysis.__version__} == {installed}
    with pytest.raises(SystemExit) as caught:
        cli.main(["--version"])
    assert (caught.value.code, capsys.readouterr().out.split()[:2]) == (0, ["sweep", installed])


@pytest.mark.parametrize("shell", grammar.SHELLS)
def test_the_completion_names_every_command(shell, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["--print-completion", shell])
    assert caught.value.code == 0
    script = capsys.readouterr().out
    assert all(name in script for name in ("plan", "submit", "run", "status", "show", "audit", "merge", "doctor"))
    with pytest.raises(SystemExit):
        analysis_main(["--print-completion", shell])
    script = capsys.readouterr().out
    assert all(name in script for name in ("best", "map", "transition", "collapse", "findings", "tradeoff", "paper"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("sweep pl", ["plan"]),
        ("sweep run --wri", ["--writer"]),
        ("sweep run --writer ga", ["gather"]),
        ("sweep plan sp", ["spec.toml"]),
        ("sweep run spec.toml --reuse ol", ["old.h5"]),
        ("analysis coll", ["collapse"]),
        ("analysis best --chao", ["--chaotic-too"]),
        ("analysis collapse --against N", ["N_over_zeta_T"]),
        ("analysis best ol", ["old.h5"]),
    ],
)
def test_bash_completes_commands_options_choices_and_files(words, found, tmp_path):
    """By bash itself, as the README has it."""
    for name in ("spec.toml", "old.h5"):
        (tmp_path / name).touch()
    program = words.partition(" ")[0]
    script = f'''
        eval "$({BIN / program} --print-completion bash)"
        COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
        $(complete -p {program} | grep -o "_shtab_[a-z]*"); echo "${{COMPREPLY[@]}}"'''
    told = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60)
    assert told.stdout.split() == found


@pytest.mark.parametrize(
    "arguments", [["--help"], ["plan", "small.toml"], ["plan", "small.toml", "--json"], ["doctor"], ["run", "--help"]]
)
def test_a_reader_that_leaves_ends_a_command_quietly(arguments, small_spec, tmp_path, environment):
    """The read end is closed before anything is written."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [BIN / "sweep", *arguments]
    try:
        told = subprocess.run(
            command, cwd=tmp_path, env=environment, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=240
        )
    finally:
        os.close(writing)
    assert told.returncode == grammar.CLOSED_PIPE
    assert not {"Traceback", "BrokenPipeError", "Exception"} & set(told.stderr.replace(":", " ").split())


@pytest.mark.parametrize("arguments", [["show", "t.h5"], ["status", "t.h5"], ["audit", "t.h5"]])
def test_a_reader_that_leaves_ends_a_command_on_a_table_quietly(arguments, small_spec, sweep, tmp_path, environment):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    test_a_reader_that_leaves_ends_a_command_quietly(arguments, small_spec, tmp_path, environment)


def test_a_full_disk_under_the_answer_is_told_in_one_line_and_changes_no_runs_end(small_spec, tmp_path, environment):
    with Path("/dev/full").open("w") as full:
        told, ran = (
            subprocess.run(
                [BIN / "sweep", *arguments],
                cwd=tmp_path,
                env=environment,
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                timeout=240,
            )
            for arguments in (["plan", small_spec], ["run", small_spec, "-o", "t.h5"])
        )
    assert (told.returncode, ran.returncode) == (2, 0)
    assert told.stderr == "sweep: what there is to tell cannot be written: No space left on device\n"
    assert "Traceback" not in ran.stderr
