#!/usr/bin/env python3
"""arguments_test.py LIST HEADERS: every number that a public function takes stands in LIST, arguments.def, as a probe, or as an
exception with its reason; and nothing stands there that is not. HEADERS is a file that lists the installed headers, with semicolons
between.

Numbers are arguments of a type of numbers, enumerations among them, arrays of numbers that are read, the numeric members of the
structs of options, and the cells of tables that a caller fills."""
import re
import sys

COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
FUNCTION = re.compile(r"^FF_API\b[^;{]*?\b(\w+)\s*\(([^;]*?)\)\s*[^;()]*;", re.M | re.S)
STRUCT = re.compile(r"typedef struct (\w+) \{(.*?)\n\} \1;", re.S)
NUMBERS = {"double", "float", "int", "unsigned", "long", "size_t", "int32_t", "int64_t", "uint32_t", "uint64_t", "ff_status"}
ENUM = re.compile(r"\benum (ff_\w+)")
# Structs that a caller fills beside those of options: their members are probed as ARGUMENT.MEMBER.
GIVEN = {"ff_noise_level", "ff_param_ref"}
# What a table is asked of: functions that only look at what it is, not at the numbers in it.
LOOKS = re.compile(r"ff_table_(?!copy|write|reduce)\w+|ff_trust_\w+|ff_places_\w+|ff_report_\w+|ff_words_\w+")


def arguments(text):
    """(name, type word, is a pointer, is const) of each argument."""
    for argument in re.sub(r"\s+", " ", text).split(","):
        name = re.search(r"(\w+)\s*(?:\[\d+\])?$", argument.strip())
        kind = re.search(r"\b(?:const |struct |volatile )*(\w+)", argument.strip())
        if name and argument.strip() not in ("void", "..."):
            yield name[1], kind[1], "*" in argument or "[" in argument, "const" in argument


def members(body):
    for line in body.split(";"):
        found = re.fullmatch(r"\s*(\w+)\s+(\w+(?:\s*,\s*\w+)*)\s*", line)
        for name in re.split(r"\s*,\s*", found[2]) if found else ():
            yield found[1], name


def wanted(text):
    """The pairs (function, argument) and (type of options, member) that must be in the list."""
    numbers = NUMBERS | set(ENUM.findall(text))
    structs = {name: list(members(body)) for name, body in STRUCT.findall(text)}
    options = {name for name in structs if name.endswith("_options")}
    pairs = set()
    for function, inside in FUNCTION.findall(text):
        for name, kind, pointer, const in arguments(inside):
            if kind in options and const:
                pairs.add((function, kind))
            elif kind in GIVEN:
                pairs |= {(function, f"{name}.{member}") for _, member in structs[kind]}
            elif kind in ("ff_dirs",) or kind in numbers and (const or not pointer):
                pairs.add((function, name))
            elif kind == "ff_constraints":
                pairs |= {(function, f"{name}.{part}") for part in ("bound.lo", "bound.hi", "prior.mean", "prior.sd", "fixed.value")}
            elif kind == "ff_table" and const and pointer and not LOOKS.fullmatch(function):
                pairs.add((function, "the table " + name))
    for name in options:
        for kind, member in structs[name]:
            inner = structs.get(kind, [])
            pairs |= {(name, f"{member}.{of}") for word, of in inner if word in numbers}
            if kind in numbers and member != "size":
                pairs.add((name, member))
    return pairs


def listed(text):
    """What the list has, and how often it gives no reason."""
    text = COMMENT.sub("", text)
    pairs = [(a, b) for word, a, b in re.findall(r"^(PROBE|OPTIONS|MEMBER)\((\w+), ([\w.]+)", text, re.M)]
    pairs += [(a, "the table t") for a in re.findall(r"^TABLE\((\w+)", text, re.M)]
    exceptions = re.findall(r'^WITHOUT\((\w+), ([\w.]+), "([^"]*)"\)', text, re.M)
    pairs += [(a, b) for a, b, _ in exceptions]
    return set(pairs), [f"{a}, {b}: no reason is given" for a, b, why in exceptions if len(why) < 10]


def differences(headers, text):
    have, said = listed(text)
    want = wanted(headers)
    said += [f"{a}, {b} is not probed" for a, b in sorted(want - have)]
    extra = {(a, b) for a, b in have - want if not b.startswith(("t", "o.")) or (a, "the table t") not in have and b == "t"}
    said += [f"{a}, {b} is probed, and there is no such number" for a, b in sorted(extra) if (a, b) not in ALSO]
    return said


# Members of options that need a probe of their own, and tables that go with a problem.
ALSO = {("ff_places_new", "t"), ("ff_trust_residual_table", "t")}

# ---- the check, checked ----------------------------------------------------------------------------------------------------------

HEADER = """typedef struct ff_a_options {
    size_t size;
    double x;
} ff_a_options;
typedef enum ff_k { FF_K = 0 } ff_k;
FF_API int ff_f(ff_k kind, double *out,
                const double *in);
FF_API int ff_g(const ff_a_options *o, const ff_table *t);
"""
LIST = """PROBE(ff_f, kind, INT, 0, 1, 0, {})
PROBE(ff_f, in, REAL, 0, 1, 0, {})
OPTIONS(ff_g, ff_a_options, 0, {})
MEMBER(ff_a_options, x, REAL, 0, 1, 0)
TABLE(ff_g, {})
"""
CASES = [
    (HEADER, LIST, None),
    (HEADER + "FF_API void ff_new(size_t n);\n", LIST, "ff_new, n is not probed"),
    (HEADER + "FF_API void ff_new(const ff_a_options *o);\n", LIST, "ff_new, ff_a_options is not probed"),
    (HEADER.replace("double x;", "double x;\n    int y;"), LIST, "ff_a_options, y is not probed"),
    (HEADER, LIST.replace("TABLE(ff_g, {})\n", ""), "ff_g, the table t is not probed"),
    (HEADER, LIST + 'WITHOUT(ff_g, x, "")\n', "ff_g, x: no reason is given"),
    (HEADER, LIST + "PROBE(ff_f, gone, INT, 0, 1, 0, {})\n", "ff_f, gone is probed, and there is no such number"),
]


def main():
    failed = False
    for header, text, expected in CASES:
        said = differences(header, text)
        if said if expected is None else expected not in said:
            print(f"the check is wrong: it says {said}, expected '{expected}'")
            failed = True
    with open(sys.argv[2]) as file:
        headers = "\n".join(COMMENT.sub("", open(path).read()) for path in file.read().strip().split(";") if path)
    with open(sys.argv[1]) as file:
        text = file.read()
    said = differences(headers, text)
    print(f"{len(wanted(headers))} numbers of {len(FUNCTION.findall(headers))} functions, {len(said)} findings")
    print("\n".join(said), end="\n" if said else "")
    return failed or bool(said)


if __name__ == "__main__":
    sys.exit(main())
