#!/usr/bin/env python3
"""Turn pFUnit test files into Fortran for the bundled test runner.

    pf_preprocess.py FILE.pf OUT.F90             the tests of one file
    pf_preprocess.py --driver OUT.f90 NAME...    the program that runs the test modules NAME...

Only what pFUnit takes too is accepted; anything else ends with `file:line: error: ...` and status 1.
The output holds the module of the file, with each assertion turned into a call and a return on failure,
and a module wrap_NAME whose procedure funit_run_tests runs the tests in turn.
"""
import os
import re
import sys

MAX_DIRECTIVE, MAX_MODULE_NAME, MAX_TEST_NAME = 120, 57, 44

# Assertion: number of operands, keywords it may have, keywords it must have.
COMPARISON, CONDITION = (2, {"tolerance", "message"}, set()), (1, {"message"}, set())
ASSERTIONS = {
    "assertEqual": COMPARISON, "assertNotEqual": COMPARISON,
    "assertLessThan": COMPARISON, "assertLessThanOrEqual": COMPARISON,
    "assertGreaterThan": COMPARISON, "assertGreaterThanOrEqual": COMPARISON,
    "assertRelativelyEqual": (2, {"tolerance", "message"}, {"tolerance"}),
    "assertTrue": CONDITION, "assertFalse": CONDITION, "assertAll": CONDITION, "assertAny": CONDITION,
    "assertNone": CONDITION, "assertNotAll": CONDITION,
    "assertIsNaN": CONDITION, "assertIsFinite": CONDITION,
    "assertFail": (1, set(), set()), "assertExceptionRaised": ((0, 1), set(), set()),
}
ASSERTION_NAMES = {name.lower(): name for name in ASSERTIONS}

# What pFUnit exports, or declares where it uses a test module; defining one of these breaks the build there.
RESERVED = set("""
abstractmatcher abstracttestparameter all_of allof any_of anyexceptions anyof array_with_size
assert_that assertall assertany assertequal assertexceptionraised assertfail assertfalse
assertgreaterthan assertgreaterthanorequal assertisfinite assertisnan assertlessthan
assertlessthanorequal assertnone assertnotall assertnotequal assertrelativelyequal assertsameshape
asserttrue atest basetestrunner cases catch catchnext contains_string debuglistener disable empty_array
ends_with equal_to every every_item expectation false fhamcrest finalize funit generic_run get_context
icase ignore_all ignore_differences initialize iparam is isarraywithsize isequal isnear isnot
isrelativelynear istrueorfalse keep_all listenerpointer loadtests_interface makecustomtest matchable
matcherdescription methodname namefilter near not output_unit parallelcontext parameterizedtestcase
predicate relatively_near resultprinter run runmethod serialcontext sourcelocation starts_with
stringcontains stringdescription stringendswith stringstartswith stub subject suite t taplistener test
testannotation testcase testlistener testlistenervector testmethod testparameter testparameters
testresult testrunner testsuite throw timeoutannotation trim_all true usertestmethod wascalled
wascalledonce wasnotcalled whitespaceoptions wrapusertestcase xmlprinter
""".split())


class DialectError(Exception):
    """What is wrong with a line of the file."""


def blank_literals(line):
    """The line without its comment and with X for every character of a literal; offsets are kept."""
    out, quote = [], ""
    for char in line:
        if quote:
            quote = "" if char == quote else quote
            out.append("X")
        elif char == "!":
            break
        else:
            quote = char if char in "'\"" else ""
            out.append("X" if quote else char)
    return "".join(out)


def split_arguments(text):
    """Split at the commas that stand outside of literals and brackets."""
    pieces, depth, start, plain = [], 0, 0, blank_literals(text)
    for i, char in enumerate(plain):
        depth += (char in "([{") - (char in ")]}")
        if depth < 0:
            raise DialectError("unbalanced brackets")
        if char == "," and depth == 0:
            pieces.append(text[start:i].strip())
            start = i + 1
    if depth or len(plain) < len(text):
        raise DialectError("unbalanced brackets")
    pieces.append(text[start:].strip())
    return pieces if text.strip() else []


def check_name(name):
    if name.lower() in RESERVED or name.lower().startswith("funit_"):
        raise DialectError(f"the name {name} belongs to pFUnit")


class TestFile:
    """One .pf file: read line by line, then written as Fortran."""

    def __init__(self, path):
        self.path, self.file = path, os.path.basename(path)
        self.module = os.path.splitext(self.file)[0]
        self.line_number = 0
        self.out = []
        self.statement = ""         # a statement so far, while continuation lines come in
        self.part = "before"        # before the module, its declarations, its procedures, after it
        self.in_definition = ""     # "type" or "interface" while inside of one
        self.seen = set()           # "use funit", "implicit none"
        self.pending = None         # the directive that waits for its code line, and its argument
        self.pending_disabled = False
        self.fixtures = {}          # before, after, testcase, constructor, testparameter: names
        self.private = False        # whether names are private unless they are in the set
        self.public = set()
        self.tests = []             # (name, line, has this, disabled, parameters)

    def read(self):
        with open(self.path, encoding="utf-8") as source:
            for self.line_number, line in enumerate(source, 1):
                self.read_line(line.rstrip("\n"))
        self.check_whole()

    def read_line(self, line):
        text = line.strip()
        if text.startswith("#") and self.pending:
            raise DialectError("a preprocessor line between a directive and its code line")
        if not text or text[0] in "!#":
            self.out.append(line)
        elif text.startswith("@"):
            self.read_directive(line, text)
        elif "@" in blank_literals(line):
            raise DialectError("a directive stands alone on its line")
        else:
            self.out.append(line)
            self.read_code(line)

    # ---- directives

    def read_directive(self, line, text):
        plain = blank_literals(text).rstrip()
        if len(line) > MAX_DIRECTIVE:
            raise DialectError(f"a directive has at most {MAX_DIRECTIVE} characters")
        if len(plain) < len(text) or "&" in plain or ";" in plain or self.statement:
            raise DialectError("a directive stands alone: no comment, continuation or semicolon")
        match = re.fullmatch(r"@(\w+)(\s*\((.*)\))?", text)
        if not match:
            raise DialectError("malformed directive")
        name, arguments = match.group(1).lower(), match.group(3)
        if self.pending and name != "disable":
            raise DialectError(f"@{self.pending[0]} waits for its code line")
        if name in ASSERTION_NAMES:
            if self.part != "procedures" or arguments is None:
                raise DialectError("an assertion is a directive with arguments in a procedure")
            self.write_assertion(ASSERTION_NAMES[name], split_arguments(arguments))
            return
        if name == "disable":
            if not self.pending or self.pending[0] != "test" or self.pending_disabled or match.group(2):
                raise DialectError("@disable stands after @test")
            self.pending_disabled = True
        elif name in ("test", "before", "after", "testcase", "testparameter"):
            self.pending = (name, self.read_option(name, match.group(2), arguments))
            if name != "test" and name in self.fixtures:
                raise DialectError(f"a second @{name}")
        else:
            raise DialectError(f"unknown directive @{match.group(1)}")
        self.out.append(f"! {text[1:]}")

    @staticmethod
    def read_option(name, brackets, arguments):
        """The one argument a directive may have: testParameters={expression} or constructor=function."""
        forms = {"test": r"testParameters\s*=\s*\{\s*(.*\S)\s*\}", "testcase": r"constructor\s*=\s*(\w+)"}
        if brackets is None:
            return None
        match = re.fullmatch(forms.get(name, r"(?!)"), arguments.strip(), re.IGNORECASE)
        if not match:
            raise DialectError(f"@{name} does not take these arguments")
        return match.group(1)

    def write_assertion(self, name, arguments):
        count, allowed, required = ASSERTIONS[name]
        keywords, operands = {}, []
        for argument in arguments:
            keyword = re.match(r"(\w+)\s*=(?!=)", blank_literals(argument))
            if keyword:
                key = keyword.group(1).lower()
                if key not in allowed or key in keywords:
                    raise DialectError(f"@{name} does not take {key}= here")
                keywords[key] = argument
            elif keywords or not argument:
                raise DialectError(f"@{name}: operands come first, tolerance= and message= by keyword")
            else:
                operands.append(argument)
        if len(operands) not in (count if isinstance(count, tuple) else (count,)):
            raise DialectError(f"@{name} has the wrong number of operands")
        if required - set(keywords):
            raise DialectError(f"@{name} needs tolerance=")
        if count == 2:
            operands = [f"funit_operand({operand})" for operand in operands]
        here = f'#line {self.line_number} "{self.path}"'
        self.out += [here, f"    call {name}( &"]
        for argument in operands + list(keywords.values()):
            self.out += [here, f"      {argument}, &"]
        self.out += [here, f"      location=SourceLocation('{self.file}', {self.line_number}))",
                     "    if (anyExceptions()) return", f'#line {self.line_number + 1} "{self.path}"']

    # ---- code

    def read_code(self, line):
        plain = blank_literals(line).strip()
        if self.pending:
            self.read_target(plain, line)
        self.statement += plain.lstrip("&").rstrip("&")
        if not plain.endswith("&"):
            statement, self.statement = self.statement.strip().lower(), ""
            self.read_statement(statement, line.strip().lower())

    def read_target(self, plain, line):
        """The code line a directive is about."""
        (name, option), self.pending = self.pending, None
        disabled, self.pending_disabled = self.pending_disabled, False
        if name in ("testcase", "testparameter"):
            base = "AbstractTestParameter" if name == "testparameter" else "[Parameterized]TestCase"
            pattern = base.replace("[", "(?:").replace("]", ")?")
            match = re.fullmatch(r"type\s*(?:,[\s\w]+)?,\s*extends\s*\(\s*(" + pattern + r")\s*\)"
                                 r"\s*(?:,[\s\w]+)?::\s*(\w+)", plain, re.IGNORECASE)
            if not match or plain != line.strip():
                raise DialectError(f"@{name} stands before `type, extends({base}) :: name`")
            self.fixtures[name] = match.group(2)
            if re.search(r",\s*public\b", plain, re.IGNORECASE):
                self.public.add(match.group(2).lower())
            if name == "testcase":
                self.fixtures.update(base=match.group(1).lower(), constructor=option)
            return
        match = re.fullmatch(r"subroutine\s+(\w+)\s*(?:\(\s*(this)?\s*\))?", plain, re.IGNORECASE)
        if not match or plain != line.strip() or self.part != "procedures":
            raise DialectError(f"@{name} stands before a plain subroutine of the module")
        procedure, has_this = match.group(1), match.group(2) is not None
        if name != "test":
            if has_this:
                raise DialectError(f"the subroutine after @{name} takes no argument")
            self.fixtures[name] = procedure
            return
        if len(procedure) > MAX_TEST_NAME:
            raise DialectError(f"a test name has at most {MAX_TEST_NAME} characters")
        if procedure.lower() in (test[0].lower() for test in self.tests):
            raise DialectError(f"a second test {procedure}")
        self.tests.append((procedure, self.line_number, has_this, disabled, option))

    def read_statement(self, statement, line):
        if self.part == "before":
            match = re.fullmatch(r"module\s+(\w+)", statement)
            if not match or match.group(1) != self.module.lower() or statement != line:
                raise DialectError(f"expected `module {self.module}`, as the file is named")
            if len(self.module) > MAX_MODULE_NAME:
                raise DialectError(f"a module name has at most {MAX_MODULE_NAME} characters")
            self.part = "declarations"
        elif self.part == "after":
            raise DialectError("code after the module")
        elif re.fullmatch(r"end\s*module(\s+\w+)?", statement):
            self.part = "after"
        elif re.match(r"use\b.*\bfunit\b", statement):
            if not re.fullmatch(r"use\s+funit", statement):
                raise DialectError("use funit as a whole, without only:")
            self.seen.add("use funit")
        elif self.part == "declarations":
            self.read_declaration(statement)
        else:
            match = re.match(r"(?!end)(?:[^'\"=]*\s)?(?:subroutine|function)\s+(\w+)", statement)
            if match:
                check_name(match.group(1))

    def read_declaration(self, statement):
        if re.match(r"end\s*(type|interface)\b", statement):
            self.in_definition = ""
            return
        if self.in_definition:
            return
        if statement == "implicit none":
            self.seen.add(statement)
        elif statement == "contains":
            self.part = "procedures"
        elif re.match(r"(abstract\s+)?interface\b", statement):
            self.in_definition = "interface"
            check_name(statement.split()[-1])
        elif statement == "private":
            self.private = True
        elif re.match(r"public\b", statement):
            self.public.update(re.findall(r"\w+", statement))
        elif not re.match(r"(use|private)\b", statement):
            if re.match(r"type\s*(,|::|\s\w)", statement) and not re.match(r"type\s*\(", statement):
                self.in_definition = "type"
            for entity in split_arguments(statement.partition("::")[2]):
                check_name(re.match(r"\w*", entity).group())

    # ---- the whole

    def check_whole(self):
        fixtures = self.fixtures
        if self.part != "after" or self.pending or self.statement:
            raise DialectError(f"the file ends before `end module {self.module}`")
        for need in ("use funit", "implicit none"):
            if need not in self.seen:
                raise DialectError(f"the module has no `{need}`")
        if not self.tests:
            raise DialectError("no @test in the file")
        if "testcase" in fixtures and ("before" in fixtures or "after" in fixtures):
            raise DialectError("a @testCase has setUp and tearDown instead of @before and @after")
        parameterised = "testparameter" in fixtures
        if parameterised != (fixtures.get("base") == "parameterizedtestcase"):
            raise DialectError("@testParameter and a @testCase extending ParameterizedTestCase go together")
        if parameterised and not fixtures["constructor"]:
            raise DialectError("a @testCase with parameters needs constructor=")
        for name, self.line_number, has_this, disabled, parameters in self.tests:
            if has_this != ("testcase" in fixtures):
                raise DialectError(f"the test {name} takes `this` if, and only if, the file has a @testCase")
            if (parameters is not None) != parameterised:
                raise DialectError("testParameters= is for every test of a file with @testParameter")
            if disabled and "testcase" in fixtures:
                raise DialectError("pFUnit does not heed @disable in a file with a @testCase")
            self.check_public(name)
        for kind in ("before", "after", "testcase", "constructor", "testparameter"):
            if fixtures.get(kind):
                self.check_public(fixtures[kind])

    def check_public(self, name):
        if self.private and name.lower() not in self.public:
            raise DialectError(f"{name} has to be public")

    def write(self, path):
        with open(path, "w", encoding="utf-8") as out:
            lines = [f'#line 1 "{self.path}"', *self.out]
            lines += [f'#line {len(lines) + 2} "{path}"', *self.wrapper()]
            out.write("\n".join(lines) + "\n")

    def wrapper(self):
        lines = ["", f"module wrap_{self.module}", "  use funit", f"  use {self.module}",
                 "  use funit_runner, only: runner_t", "  implicit none", "  private",
                 "  public :: funit_run_tests", "contains",
                 "  subroutine funit_run_tests(funit_tests)",
                 "    type(runner_t), intent(inout) :: funit_tests"]
        for test in self.tests:
            lines += self.wrap_test(*test)
        return lines + ["  end subroutine funit_run_tests", f"end module wrap_{self.module}"]

    def wrap_test(self, name, line, has_this, disabled, parameters):
        fixtures = self.fixtures
        label = f"'{self.module}', &\n      '{name}'"
        if disabled:
            return [f"    call funit_tests%skip({label}, {line})"]
        argument, declared, prepared = "", [], []
        set_up = [f"      call {fixtures['before']}()"] if "before" in fixtures else []
        tear_down = [f"        call {fixtures['after']}()"] if "after" in fixtures else []
        if has_this:
            argument = "funit_case"
            declared = ["      block", f"      type({fixtures['testcase']}) :: funit_case"]
            set_up, tear_down = ["      call funit_case%setUp()"], ["        call funit_case%tearDown()"]
        value = "funit_values(funit_i)" if parameters else ""
        if has_this and fixtures["constructor"]:
            prepared = [f"      funit_case = {fixtures['constructor']}({value})"]
        if parameters:
            label += f" // '[' // trim({value}%toString()) // ']'"
            prepared += [f"      allocate (funit_case%testParameter, source={value})"]
        lines = [f"    if (funit_tests%begins({label}, {line})) then", *declared, *prepared, *set_up,
                 "      if (.not. anyExceptions()) then", f"        call {name}({argument})", *tear_down,
                 "      end if", *(["      end block"] if has_this else []),
                 "      call funit_tests%ends()", "    end if"]
        if parameters:
            lines = ["    block", f"    type({fixtures['testparameter']}), allocatable :: funit_values(:)",
                     "    integer :: funit_i", f"    allocate (funit_values, source={parameters})",
                     "    do funit_i = 1, size(funit_values)", *lines, "    end do", "    end block"]
        return lines


def write_driver(path, modules):
    uses = [f"  use wrap_{m}, only: run_{m} => funit_run_tests" for m in modules]
    calls = [f"  call run_{m}(tests)" for m in modules]
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(["program run_unit_tests", "  use funit_runner, only: runner_t", *uses,
                             "  implicit none", "  type(runner_t) :: tests", "  call tests%start()", *calls,
                             "  call tests%finish()", "end program run_unit_tests"]) + "\n")


def main(arguments):
    if len(arguments) > 2 and arguments[0] == "--driver":
        write_driver(arguments[1], arguments[2:])
        return 0
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    test_file = TestFile(arguments[0])
    try:
        test_file.read()
    except DialectError as error:
        print(f"{test_file.path}:{test_file.line_number}: error: {error}", file=sys.stderr)
        return 1
    test_file.write(arguments[1])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
