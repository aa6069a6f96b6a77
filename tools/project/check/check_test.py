#!/usr/bin/env python3
"""The checks find what they are made to find, and nothing in what is right."""
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "../../../test/golden")]
import behaviour  # noqa: E402
import cites  # noqa: E402
import cycles  # noqa: E402
import function_length  # noqa: E402
import layering  # noqa: E402
import skipped  # noqa: E402
import sources  # noqa: E402
import syntax  # noqa: E402


class Repository(unittest.TestCase):
    """A small repository of its own for each test."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.before = os.getcwd()
        os.chdir(self.folder.name)
        subprocess.run(["git", "init", "-q"], check=True)

    def tearDown(self):
        os.chdir(self.before)
        self.folder.cleanup()

    def write(self, path, text):
        if os.path.dirname(path):
            os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)


class Layering(Repository):
    def check(self):
        subprocess.run(["git", "add", "-A"], check=True)
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            code = layering.main()
        return code, out.getvalue()

    def test_a_core_sees_neither_shells_nor_threads(self):
        self.write("common/core/a.h", "#include <vector>\n")
        self.write("backend/core/b.h", '#include "common/core/a.h"\n')
        self.assertEqual(self.check()[0], 0)
        self.write("backend/core/c.h", '#include "backend/process/d.h"\n#include <thread>\n')
        code, text = self.check()
        self.assertEqual(code, 1)
        self.assertIn("backend/core/c.h:1: backend/core must not include backend/process/d.h", text)
        self.assertIn("backend/core/c.h:2: backend/core must not include <thread>", text)


class Cycles(Repository):
    def groups(self):
        return cycles.cycles(cycles.folder_graph(cycles.includes()))

    def test_one_direction_is_fine(self):
        self.write("a/x.h", "")
        self.write("b/y.h", '#include "a/x.h"\n')
        self.write("c/z.h", '#include "b/y.h"\n#include "a/x.h"\n')
        self.assertEqual(self.groups(), [])

    def test_folders_that_include_each_other(self):
        self.write("a/x.h", '#include "b/y.h"\n')
        self.write("a/w.h", "")
        self.write("b/y.h", '#include "a/w.h"\n')
        self.assertEqual(self.groups(), [["a", "b"]])

    def test_cycles_of_three(self):
        self.write("a/x.h", '#include "b/y.h"\n')
        self.write("b/y.h", '#include "c/z.h"\n')
        self.write("c/z.h", '#include "a/w.h"\n')
        self.write("a/w.h", "")
        self.assertEqual(self.groups(), [["a", "b", "c"]])

    def test_tests_may_include_upwards(self):
        self.write("a/x.h", "")
        self.write("a/x_test.cc", '#include "b/y.h"\n')
        self.write("b/y.h", '#include "a/x.h"\n')
        self.assertEqual(self.groups(), [])

    def test_rooms_include_downwards_only(self):
        self.write("tools/lab/slam/x.h", "")
        self.write("tools/data/log/y.h", '#include "tools/lab/slam/x.h"\n')
        self.write("common/core/z.h", '#include "tools/data/log/y.h"\n')
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            self.assertEqual(cycles.main(), 1)
        self.assertIn("tools/data/log/y.h:1: tools/data is below tools/lab", out.getvalue())
        self.assertIn("common/core/z.h:1: includes a tool", out.getvalue())


class FunctionLength(unittest.TestCase):
    def lengths(self, text):
        return {name: lines for _, lines, name in function_length.functions(text)}

    def test_every_kind_of_function(self):
        text = '''
namespace gw {
struct A {
  A() : x{1}, y(2) {
    x = 3;
  }
  int get() const { return x; }
  int x, y;
};
constexpr int kTable[] = {
    1,
    2,
};
template <typename T>
T Twice(
    T value) {  // braces in a comment: }}}
  const char* text = "}}}";
  const auto f = [&](int a) {
    if (a > 0) {
      return a;
    }
    return 0;
  };
  return value;
}
}  // namespace gw
'''
        self.assertEqual(self.lengths(text), {"A": 3, "get": 1, "Twice": 12})

    def test_a_long_one_is_counted_to_its_last_line(self):
        self.assertEqual(self.lengths("void F() {\n" + "  g();\n" * 90 + "}\n"), {"F": 92})

    def test_separators_in_numbers_open_no_literal(self):
        self.assertEqual(self.lengths("int F() {\n  return 1'000'000;\n}\nint G() {\n}\n"), {"F": 3, "G": 2})


class Cites(Repository):
    def test_links(self):
        self.write("docs/a.md", "# One heading\n[ok](b.md) [ok](#one-heading) [ok](https://x.y/z) [bad](c.md) [bad](b.md#no)\n"
                   "`docs/b.md` and `docs/none.md`\n")
        self.write("docs/b.md", "")
        found = list(cites.broken_links("docs/a.md"))
        self.assertEqual(len(found), 3, found)

    def test_cites_of_files_outside(self):
        self.write("a/x.h", "// As in notes.md, see y.h and a/none.h.\n#include <z.h>\nint x;  // docs/b.md\n")
        found = list(cites.bad_cites("a/x.h", cites.ends(["a/x.h", "a/y.h", "docs/b.md"])))
        self.assertEqual(len(found), 2, found)
        self.assertIn("notes.md", found[0])
        self.assertIn("a/none.h", found[1])


class Headers(Repository):
    def test_a_header_that_needs_another(self):
        self.write("a/good.h", "#include <string>\ninline std::string Good() { return {}; }\n")
        self.write("a/bad.h", "inline std::string Bad() { return {}; }\n")
        compiled = {header: syntax.compile_one(("c++", header, ["-I."], f'#include "{header}"\n'))
                    for header in ("a/good.h", "a/bad.h")}
        self.assertIsNone(compiled["a/good.h"])
        self.assertIn("does not compile", compiled["a/bad.h"])

    def test_the_first_include_of_its_source_needs_no_unit_of_its_own(self):
        self.write("a/x.cc", '// What it is.\n#include "a/x.h"\n#include <string>\n')
        self.write("a/y.cc", '#include <string>\n#include "a/y.h"\n')
        known = {"a/x.cc": [], "a/y.cc": []}
        self.assertTrue(syntax.stands_first("a/x.h", known))
        self.assertFalse(syntax.stands_first("a/y.h", known))
        self.assertFalse(syntax.stands_first("a/z.h", known))


class Skipped(Repository):
    def test_cases_and_whole_tests(self):
        self.write("tests.xml", """<testsuite>
<testcase name="data_test"><system-out>[ RUN      ] A.B
/x/y.cc:3: Skipped
no recording here

[  SKIPPED ] A.B (0 ms)
[ RUN      ] A.C
[       OK ] A.C (0 ms)
</system-out></testcase>
<testcase name="kvm_test"><skipped message="SKIP_RETURN_CODE=77"/><system-out>no /dev/kvm
</system-out></testcase>
<testcase name="good"><system-out>fine</system-out></testcase>
</testsuite>""")
        self.assertEqual(sorted(skipped.skipped("tests.xml")),
                         [("data_test: A.B", "no recording here"), ("kvm_test", "no /dev/kvm")])


class Excuses(unittest.TestCase):
    def finish(self, violations, excused):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            code = sources.finish("x", violations, excused=excused)
        return code, out.getvalue()

    def test_excused_and_new_and_mended(self):
        self.assertEqual(self.finish(["a.h:12: is bad"], ["a.h: is bad"])[0], 0)
        self.assertEqual(self.finish(["a.h:12: is bad", "b.h:1: is bad"], ["a.h: is bad"])[0], 1)
        code, text = self.finish([], ["a.h: is bad"])
        self.assertEqual(code, 1)
        self.assertIn("delete its line", text)


class Behaviour(unittest.TestCase):
    ACCEPTED = ["cpu vendor: A", "x full: APE live [mm]: 2.0", "x full: sha256 dr.tum 12"]

    def test_what_counts_as_a_difference(self):
        self.assertEqual(behaviour.compare(self.ACCEPTED, self.ACCEPTED), ([], False))
        other_bytes = [self.ACCEPTED[0], self.ACCEPTED[1], "x full: sha256 dr.tum 34"]
        diff, counts = behaviour.compare(self.ACCEPTED, other_bytes)
        self.assertIn("+x full: sha256 dr.tum 34", diff)
        self.assertTrue(counts)

    def test_on_another_vendors_cpu_figures_count_and_hashes_do_not(self):
        self.assertFalse(behaviour.compare(self.ACCEPTED, ["cpu vendor: B", self.ACCEPTED[1], "x full: sha256 dr.tum 34"])[1])
        self.assertTrue(behaviour.compare(self.ACCEPTED, ["cpu vendor: B", "x full: APE live [mm]: 3.0", self.ACCEPTED[2]])[1])


if __name__ == "__main__":
    unittest.main()
