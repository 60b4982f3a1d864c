#!/usr/bin/env python3
"""Check the unit-test runner: counts, messages, exit status and options, and what its preprocessor rejects.

    check_runner.py ASSERTIONS FIXTURES FAILURES [TRAPS]     the programs of the suites of this directory

Without TRAPS they are run by pFUnit. Then the counts, the lines of the failures, the exit status and the
option -f have to be the same.
"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
PREPROCESSOR = os.path.join(os.path.dirname(HERE), "pf_preprocess.py")
ASSERTIONS, FIXTURES, FAILURES = sys.argv[1:4]
BUNDLED = len(sys.argv) > 4
bundled = unittest.skipUnless(BUNDLED, "about the bundled runner")


def run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8",
                          errors="replace")


def expected_failures(file="test_runner_failures.pf"):
    """(number, text, line) of each line below a comment `! fails: text`, in the order of the file."""
    with open(os.path.join(HERE, file), encoding="utf-8") as source:
        lines = source.read().split("\n")
    marks = [re.fullmatch(r"\s*! fails:\s*(.*)", line) for line in lines]
    return [(i + 2, mark.group(1), lines[i + 1]) for i, mark in enumerate(marks) if mark]


class Runs(unittest.TestCase):
    """Programs built from the .pf files of this directory."""

    def check(self, command, closing, status):
        result = run(*command)
        self.assertEqual(closing, result.stdout.split("\n")[-2], result.stdout + result.stderr)
        self.assertEqual(status, result.returncode)
        return result.stdout

    def test_pass(self):
        output = self.check([ASSERTIONS], "11 passed, 0 failed", 0)
        self.assertIn("\n (11 tests, 1 disabled)\n", "\n" + output)
        self.assertIn("\n OK\n", "\n" + output)

    def test_fixtures_and_parameters(self):
        self.check([FIXTURES], "7 passed, 0 failed", 0)

    def test_filter(self):
        self.check([FIXTURES, "-f", "test_points"], "3 passed, 0 failed", 0)
        self.check([FIXTURES, "-f", "[order 2]"], "1 passed, 0 failed", 0)
        self.check([FIXTURES, "-f", "test_runner_fixture_suite."], "2 passed, 0 failed", 0)
        self.check([FAILURES, "-f", "test_passes", "-v"], "2 passed, 0 failed", 0)

    def test_nothing_to_run(self):
        for only in ("no_such_test", "test_not_run"):
            output = self.check([ASSERTIONS, "-f", only], "0 passed, 0 failed", 3)
            if BUNDLED:
                self.assertNotIn("OK", output)

    def test_failures(self):
        output = self.check([FAILURES], "2 passed, 34 failed", 2)
        self.assertIn("\n FAILURES!!!\n", "\n" + output)
        for line, _, code in expected_failures():
            if code.lstrip().startswith("@"):
                self.assertIn(f"test_runner_failures.pf:{line}", output)

    @bundled
    def test_messages(self):
        for program, file in ((FAILURES, "test_runner_failures.pf"), (sys.argv[4], "test_runner_traps.pf")):
            output = run(program).stdout.split("\n")
            reports = [line for line in output if line.startswith(f"{file}:")]
            expected = expected_failures(file)
            self.assertEqual(len(expected), len(reports))
            for line, text, _ in expected:
                report = [r for r in reports if r.startswith(f"{file}:{line}: ")]
                self.assertEqual(1, len(report), f"line {line}: {report}")
                self.assertIn(text, report[0])

    @bundled
    def test_verbose(self):
        output = run(ASSERTIONS, "-v").stdout
        self.assertIn("test_runner_assertions_suite.test_text ... ok\n", output)
        self.assertIn("test_runner_assertions_suite.test_not_run ... disabled\n", output)
        self.assertIn("test_runner_fixture_suite.test_filled ... ok\n", run(FIXTURES, "-v").stdout)
        self.assertIn("test_points[order 3] ... ok\n", run(FIXTURES, "-v").stdout)
        self.assertIn("test_runner_failures_suite.test_fail ... FAILED\n", run(FAILURES, "-v").stdout)
        self.assertNotIn("...", run(ASSERTIONS).stdout)

    def test_unknown_option(self):
        for options in (["-x"], ["-f"], ["test_text"]):
            result = run(ASSERTIONS, *options)
            self.assertEqual(1, result.returncode)
            self.assertIn("usage:", result.stderr)


PLAIN = """module test_it
  use funit
  implicit none
contains
  @test
  subroutine test_one()
    @assertTrue(.true.)
  end subroutine test_one
end module test_it
"""

FIXTURE = """module test_it
  use funit
  implicit none
  @testCase(constructor=new_case)
  type, extends(TestCase) :: my_case
  end type my_case
contains
  function new_case() result(it)
    type(my_case) :: it
  end function new_case
  @test
  subroutine test_one(this)
    class(my_case), intent(inout) :: this
    @assertTrue(.true.)
  end subroutine test_one
end module test_it
"""

PARAMETERS = """module test_it
  use funit
  implicit none
  @testParameter
  type, extends(AbstractTestParameter) :: my_parameter
  end type my_parameter
  @testCase(constructor=new_case)
  type, extends(ParameterizedTestCase) :: my_case
  end type my_case
contains
  @test(testParameters={[my_parameter()]})
  subroutine test_one(this)
    class(my_case), intent(inout) :: this
    @assertTrue(.true.)
  end subroutine test_one
end module test_it
"""

TRUE = "@assertTrue(.true.)"

# A file, what is replaced in it by what, and the line and text of the error.
REJECTED = [
    (PLAIN, "module test_it\n", "module test_other\n", 1, "expected `module test_it`"),
    (PLAIN, "module test_it\n", "module test_it ! with a comment\n", 1, "expected `module test_it`"),
    (PLAIN, "module test_it\n", "program test_it\n", 1, "expected `module test_it`"),
    (PLAIN, "use funit", "use funit, only: TestCase", 2, "without only:"),
    (PLAIN, "  use funit\n", "", 8, "no `use funit`"),
    (PLAIN, "  implicit none\n", "", 8, "no `implicit none`"),
    (PLAIN, "end module test_it\n", "end module test_it\nmodule more\n", 10, "code after the module"),
    (PLAIN, "end module test_it\n", "", 8, "ends before"),
    (PLAIN, "  @test\n", "", 8, "no @test"),
    (PLAIN, "implicit none", "implicit none\n  integer :: n, near(2) = 0", 4, "near belongs to pFUnit"),
    (PLAIN, "implicit none", "implicit none\n  integer :: n, &\n    run", 5, "run belongs to pFUnit"),
    (PLAIN, "test_one()", "not()", 6, "not belongs to pFUnit"),
    (PLAIN, "test_one()", "funit_one()", 6, "funit_one belongs to pFUnit"),
    (PLAIN, "test_one()", "test_" + 40 * "x" + "()", 6, "at most 44"),
    (PLAIN, "test_one()", "test_one(this)", 6, "takes `this` if, and only if"),
    (PLAIN, "test_one()", "test_one(a, b)", 6, "before a plain subroutine"),
    (PLAIN, "subroutine test_one()", "recursive subroutine test_one()", 6, "before a plain subroutine"),
    (PLAIN, "subroutine test_one()", "subroutine test_one() ! why", 6, "before a plain subroutine"),
    (PLAIN, "implicit none", "implicit none\nprivate\npublic :: test_two", 8, "test_one has to be public"),
    (PLAIN, "@test\n", "@test ! why\n", 5, "stands alone"),
    (PLAIN, "@test\n", "@test;\n", 5, "stands alone"),
    (PLAIN, "@test\n", "@test(npes=[1])\n", 5, "does not take these arguments"),
    (PLAIN, "@test\n", "@test(testParameters={[1]})\n", 6, "testParameters="),
    (PLAIN, "@test\n", "@test\n  @test\n", 6, "@test waits"),
    (PLAIN, "@test\n", "@test\n#ifdef A\n", 6, "between a directive and its code line"),
    (PLAIN, "@test\n", "@mpitest\n", 5, "unknown directive @mpitest"),
    (PLAIN, "@test\n", "@disable\n  @test\n", 5, "stands after @test"),
    (PLAIN, "@test\n", "@before\n  subroutine a()\n  end subroutine\n  @before\n", 8, "a second @before"),
    (PLAIN, "@test\n", "@before\n  subroutine a(this)\n  end subroutine\n  @test\n", 6, "takes no argument"),
    (PLAIN, "end module", "@test\nsubroutine test_one()\nend subroutine\nend module", 10, "a second test"),
    (PLAIN, TRUE, "@assertTrue(.true., &\n    message='a')", 7, "stands alone"),
    (PLAIN, TRUE, "@assertTrue(.true.) ! why", 7, "stands alone"),
    (PLAIN, TRUE, "@assertTrue(.true.); a = 1", 7, "stands alone"),
    (PLAIN, TRUE, "if (.true.) @assertTrue(.true.)", 7, "stands alone"),
    (PLAIN, TRUE, "@assertTrue(.true., message='" + 100 * "x" + "')", 7, "at most 120"),
    (PLAIN, TRUE, "@assertTrue", 7, "with arguments"),
    (PLAIN, TRUE, "@assertTrue(.true.", 7, "malformed directive"),
    (PLAIN, TRUE, "@assertTrue((.true.)", 7, "unbalanced brackets"),
    (PLAIN, TRUE, "@assertTrue()", 7, "wrong number of operands"),
    (PLAIN, TRUE, "@assertTrue(.true., 'message')", 7, "wrong number of operands"),
    (PLAIN, TRUE, "@assertEqual(1)", 7, "wrong number of operands"),
    (PLAIN, TRUE, "@assertEqual(1, 2, 3)", 7, "wrong number of operands"),
    (PLAIN, TRUE, "@assertEqual(1, , 3)", 7, "operands come first"),
    (PLAIN, TRUE, "@assertEqual(1, message='a', 2)", 7, "operands come first"),
    (PLAIN, TRUE, "@assertEqual(1, 2, location=here)", 7, "does not take location="),
    (PLAIN, TRUE, "@assertTrue(.true., tolerance=1.0)", 7, "does not take tolerance="),
    (PLAIN, TRUE, "@assertEqual(1, 2, message='a', message='b')", 7, "does not take message="),
    (PLAIN, TRUE, "@assertRelativelyEqual(1.0, 2.0)", 7, "needs tolerance="),
    (PLAIN, TRUE, "@assertAssociated(a)", 7, "unknown directive"),
    (PLAIN, "contains", TRUE + "\ncontains", 4, "in a procedure"),
    (FIXTURE, "implicit none", "implicit none\nprivate\npublic test_one", 14, "my_case has to be public"),
    (FIXTURE, "test_one(this)", "test_one()", 12, "takes `this` if, and only if"),
    (FIXTURE, "extends(TestCase)", "extends(other_case)", 5, "stands before `type, extends"),
    (FIXTURE, "constructor=new_case", "npes=[1]", 4, "does not take these arguments"),
    (FIXTURE, "@test\n", "@test\n@disable\n", 13, "does not heed @disable"),
    (FIXTURE, "@test\n", "@after\nsubroutine a()\nend subroutine\n@test\n", 19, "setUp and tearDown"),
    (FIXTURE, "extends(TestCase)", "extends(ParameterizedTestCase)", 16, "go together"),
    (PARAMETERS, "(constructor=new_case)", "", 16, "needs constructor="),
    (PARAMETERS, "(testParameters={[my_parameter()]})", "", 12, "testParameters="),
    (PARAMETERS, "extends(AbstractTestParameter)", "extends(my_base)", 5, "stands before `type, extends"),
]


class Preprocessor(unittest.TestCase):
    """Files accepted and rejected."""

    def preprocess(self, text):
        with tempfile.TemporaryDirectory() as directory:
            source, output = os.path.join(directory, "test_it.pf"), os.path.join(directory, "test_it.F90")
            with open(source, "w", encoding="utf-8") as out:
                out.write(text)
            result = run(sys.executable, PREPROCESSOR, source, output)
            self.assertEqual(result.returncode == 0, os.path.exists(output))
            return result.returncode, result.stderr.replace(directory + os.sep, "")

    def test_accepted(self):
        for text in (PLAIN, FIXTURE, PARAMETERS, PLAIN.replace("test_one()", "test_one"),
                     PLAIN.replace("implicit none", "implicit none\n  private\n  public :: test_one")):
            self.assertEqual((0, ""), self.preprocess(text))

    def test_rejected(self):
        for text, old, new, line, message in REJECTED:
            with self.subTest(new=new, message=message):
                self.assertIn(old, text)
                status, errors = self.preprocess(text.replace(old, new, 1))
                self.assertEqual(1, status, errors)
                self.assertTrue(errors.startswith(f"test_it.pf:{line}: error: "), errors)
                self.assertIn(message, errors)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
