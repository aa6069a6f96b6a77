#!/usr/bin/env python3
"""Instrumented sources say what they said before, and what cannot be changed is left alone."""
import contextlib
import io
import os
import pathlib
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import instrument  # noqa: E402
import sensitivity  # noqa: E402

HEAD = '#include "x.h"\n'


def ids(constants):
    return [c.id for c in constants if not c.why]


class Instrument(unittest.TestCase):
    def test_a_constant_becomes_a_call_with_its_name_type_and_value(self):
        text, constants = instrument.instrument_text("a.cc", HEAD + "constexpr double kFoo = 1e-3;  // m\n")
        self.assertIn('const double kFoo = gw::override_value::Of<double>("a.cc:kFoo", 1e-3);  // m', text)
        self.assertTrue(text.startswith('#include "tools/lab/sensitivity/override.h"') or
                        '#include "tools/lab/sensitivity/override.h"\n#include "x.h"' in text)
        self.assertEqual(ids(constants), ["a.cc:kFoo"])

    def test_members_locals_and_several_in_one_line(self):
        text, constants = instrument.instrument_text(
            "a.h", HEAD + "  static constexpr int kMember = 3;\n  constexpr float kLocal = 2.5F;\n"
                          "constexpr double kA = 1, kB = std::pow(2, 3);\n")
        self.assertIn("  inline static const int kMember = ", text)
        self.assertIn("  static const float kLocal = ", text)
        self.assertIn('kB = gw::override_value::Of<double>("a.h:kB", std::pow(2, 3));', text)
        self.assertEqual(len(ids(constants)), 4)

    def test_two_of_one_name_are_told_apart(self):
        _, constants = instrument.instrument_text(
            "a.cc", HEAD + "  constexpr int kR = 2;\n  constexpr int kR = 3;\n")
        self.assertEqual(ids(constants), ["a.cc:kR", "a.cc:kR#2"])

    def test_what_is_made_of_others_follows_them_without_a_change_of_its_own(self):
        text, constants = instrument.instrument_text(
            "a.cc", HEAD + "constexpr int kR = 2;\nconstexpr int kSide = 2 * kR + 1;\n")
        self.assertIn("const int kSide = 2 * kR + 1;", text)
        self.assertNotIn("constexpr", text)
        self.assertEqual(ids(constants), ["a.cc:kR"])
        self.assertEqual(constants[1].why, "made of kR")

    def test_no_constant_no_change(self):
        source = HEAD + "int kFoo = 3;\nconstexpr std::array<int, 2> kTable = {1, 2};\nconstexpr char kName[] = \"a\";\n"
        self.assertEqual(instrument.instrument_text("a.cc", source), (source, []))

    def test_the_compiler_names_what_has_to_stay(self):
        source = HEAD + "constexpr int kSize = 4;\nconstexpr int kOther = 5;\n"
        _, constants = instrument.instrument_text("b/a.cc", source)
        gcc = ("../b/a.cc:9:20: error: the value of 'gw::kSize' is not usable in a constant expression\n"
               "    9 |   std::array<int, kSize> table;\n")
        self.assertEqual(instrument.to_revert(gcc, constants), {"b/a.cc:kSize"})
        text, constants = instrument.instrument_text("b/a.cc", source, {"b/a.cc:kSize"})
        self.assertIn("constexpr int kSize = 4;", text)
        self.assertEqual([c.why for c in constants], ["needed by the compiler", ""])

    def test_shares_near_one_are_changed_by_what_they_lack(self):
        self.assertEqual(sensitivity.directions("kFewestShare", "0.6"), ("less", "more"))
        self.assertEqual(sensitivity.directions("kFewestShare", "0.25"), ("half", "double"))
        self.assertEqual(sensitivity.directions("kHintSigma", "0.6"), ("half", "double"))

    def test_every_constant_of_the_cores_is_found(self):
        root = HERE.parents[2]
        constants = []
        for path in instrument.sources(root, sensitivity.FOLDERS):
            constants += instrument.instrument_text(path, (root / path).read_text())[1]
        self.assertGreater(len(ids(constants)), 150)
        self.assertIn("common/vision/pose_optimizer.cc:kRobustRounds", ids(constants))
        self.assertEqual(len({c.id for c in constants}), len(constants))


class Groups(unittest.TestCase):
    """Runs of a made-up program: one constant of four matters, and the group of its file with it."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.scratch = pathlib.Path(self.folder.name)
        (self.scratch / "constants.csv").write_text(
            "constant,line,value,left_as_it_is\na.cc:kA,1,2,\na.cc:kB,2,3,\nb.cc:kC,1,4,\nb.cc:kD,2,4,\nb.cc:kE,3,4,index\n")
        self.ran = []
        self.before = sensitivity.run_once
        sensitivity.run_once = self.run_once

    def tearDown(self):
        sensitivity.run_once = self.before
        self.folder.cleanup()

    def run_once(self, _scratch, log, changes, seed):
        self.ran.append(changes)
        digest = "changed" if any(c == "b.cc:kC" for c, _ in changes) else "same"
        return [{"constant": c, "direction": d, "log": log.name, "seed": seed, "before": "", "after": "", "live": "1",
                 "keyframes": "1", "digest": digest, "exit": 0, "cpu_s": "0"} for c, d in changes or [("", "")]]

    def test_files_without_effect_cost_one_run_a_direction(self):
        log = type("Log", (), {"name": "log", "dr_only": False})()
        sensitivity.run(self.scratch, [log], "", 2)
        a, b = [["a.cc:kA", "a.cc:kB"], ["b.cc:kC", "b.cc:kD"]]
        self.assertEqual([[c for c, _ in changes] for changes in self.ran],
                         [[], [], a, a, b, [b[0]], [b[1]], b, [b[0]], [b[1]]])
        rows = sensitivity.read(self.scratch / "runs.csv")
        self.assertEqual({r["constant"] for r in rows if r["digest"] == "changed"}, {"b.cc:kC"})
        self.assertEqual(len(rows), 2 + 8)
        self.ran.clear()
        sensitivity.run(self.scratch, [log], "", 2)
        self.assertEqual(self.ran, [])


class Table(unittest.TestCase):
    def row(self, **changes):
        return {"constant": "", "direction": "", "log": "x", "seed": "0", "exit": "0", "digest": "a", "live": "0.01", "keyframes": "0.01", **changes}

    def scatter(self):
        return sensitivity.Scatter([self.row(), self.row(seed="1", live="0.012"), self.row(seed="2", live="0.014")])

    def test_effects_are_in_deviations_of_the_starts(self):
        self.assertIsNone(sensitivity.effect(self.row(), self.scatter()))
        worse, moved = sensitivity.effect(self.row(digest="b", live="0.016", keyframes="0.008"), self.scatter())
        self.assertAlmostEqual(worse, 3)
        self.assertAlmostEqual(moved, 4)  # of the keyframes, whose starts agree: a twentieth
        self.assertEqual(sensitivity.effect(self.row(exit="-11", digest=""), self.scatter())[0], float("inf"))

    def test_cells_say_what_came_out(self):
        self.assertEqual(sensitivity.cell(self.row(), self.scatter()), "=")
        self.assertEqual(sensitivity.cell(self.row(digest="b", live="0.016"), self.scatter()), "0.0160 0.0100")
        self.assertEqual(sensitivity.cell(self.row(digest="b", log="x+dr"), self.scatter()), "0.0100")
        self.assertEqual(sensitivity.cell(self.row(exit="-11", digest=""), self.scatter()), "fails")
        self.assertEqual(sensitivity.cell(None, self.scatter()), "not run")

    def test_verdicts(self):
        self.assertEqual(sensitivity.verdict([None, None]), "=")
        self.assertEqual(sensitivity.verdict([None, (0.5, 9)]), "within")
        self.assertEqual(sensitivity.verdict([(2, 2), (0, 1)]), "some")
        self.assertEqual(sensitivity.verdict([(3.1, 3.1), None]), "sharp")

    def test_a_constant_stands_with_the_log_on_which_it_moves_most(self):
        with tempfile.TemporaryDirectory() as folder:
            scratch = pathlib.Path(folder)
            (scratch / "constants.csv").write_text("constant,line,value,left_as_it_is\na.cc:kA,1,2,\na.cc:kB,2,3,\na.cc:kC,2,3,\na.cc:kD,2,3,index\n")
            runs = sensitivity.Runs(scratch / "runs.csv")
            row = lambda **changes: {"before": "", "after": "", "cpu_s": "0", **self.row(**changes)}
            runs.add([row(), row(log="y")])
            for log, live in (("x", "0.011"), ("y", "0.05")):
                runs.add([row(constant="a.cc:kA", direction="half", log=log, live=live, digest="b"), row(constant="a.cc:kA", direction="double", log=log)])
                runs.add([row(constant="a.cc:kB", direction=d, log=log) for d in ("half", "double")])
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                sensitivity.table(scratch)
            x, y = out.getvalue().split("### y")
            self.assertNotIn("kA", x)
            self.assertIn("| `a.cc:kA` | 2 | 0.0500 0.0100 | = | sharp |", y)
            self.assertIn("On x, y:\n\n* `a.cc`: `kB`", y)
            self.assertIn("### Not run\n\n* `a.cc`: `kC`", y)
            self.assertNotIn("kD", y)


if __name__ == "__main__":
    os.environ.pop("GW_OVERRIDE", None)
    unittest.main()
