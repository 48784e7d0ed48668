#!/usr/bin/env python3
"""schema_test.py PROGRAM SOURCE_DIR: the schemas in docs/schema say of every JSON document what is there, no more and no less.

  a schema           is one of draft 2020-12, closed (a key that it does not name is wrong), describes every key; it is what
                     --print-schema prints
  a document         is made by every command in RUNS, which switch on every part, and is valid
  a key              that no document of RUNS had is one that the program lost, or RUNS misses it: both fail; NOT_MADE has exceptions
  docs/json.md       runs, and lists every document
  a planted mistake  in a document is found: in every object a key too many, one too few of those required, a value of a wrong type"""
import concurrent.futures
import copy
import functools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

try:
    from jsonschema import Draft202012Validator as Validator
except ImportError:
    print("skipped: python3-jsonschema is not installed for %s" % sys.executable)
    sys.exit(77)

PROGRAM, TOP = os.path.abspath(sys.argv[1]), sys.argv[2]
SCHEMAS = os.path.join(TOP, "docs", "schema")

# What a run cannot bring about: place in a schema -> why.
NOT_MADE = {
    "fit#/$defs/fit/properties/correlation/anyOf/1": "the program always asks for standard errors",
    **{"ndf#/$defs/warning/properties/" + key: "the writer of warnings is that of fits; no warning of a retrieval names any yet"
       for key in ("parameter", "parameters", "channel", "channels")},
}

# name: a call of `simulate` that makes it
FILES = {
    "paint.csv": "ggx+lambert --set alpha_x=0.2,alpha_y=0.45,r_xy=0.4,f0=0.9:0.6:0.3,kd=0.1 --grid goniometer:15 --noise 0.02",
    "grey.csv": "ggx+lambert --set alpha=0.3,kd=0.1 --grid goniometer:10 --noise 0.01",
    "bright.csv": "ggx+lambert --set alpha=0.3,f0=1,ks=1.6,kd=0.05 --grid goniometer:10 --noise 0.01",
    "sigma.csv": "ggx+lambert --set alpha=0.2,f0=0.5,kd=0.1 --grid scattered:300 --noise 0.05 --noise-floor 0.02 --sigma",
    "many.csv": "ggx+lambert --set alpha=0.3,kd=0.1,f0=0.3:0.34:0.38:0.42:0.46:0.5:0.54:0.58:0.62:0.66:0.7 --grid scattered:400 --noise 0.02",
    "coarse.csv": "ggx+lambert --set alpha=0.2,f0=0.9:0.6:0.3,kd=0.02 --grid goniometer:30 --noise 0.05",
    "exact.csv": "ggx+lambert --set alpha=0.3,f0=0.5,kd=0.1 --grid scattered:200",
    "dark.csv": "ggx+lambert --set alpha=0.3,f0=0.5:0,kd=0.1:0 --grid scattered:200:0.9",
    "peak.csv": "ggx+lambert --set alpha=0.3,f0=0.5,kd=0.1 --grid scattered:400:1 --noise 0.02",
    "merl.binary": "ggx+lambert --set alpha=0.3,f0=0.5,kd=0.1 --grid merl --format merl",
}
# Written by hand: what `simulate` does not make.
WRITTEN = {
    "directions.csv": "theta_i,phi_i,theta_o,phi_o\n30,0,30,180\n45,0,20,90\n",
    "nothing.csv": "theta_i,phi_i,theta_o,phi_o\n",
    "nothing_usable.csv": "theta_i,phi_i,theta_o,phi_o,f\n30,0,95,180,1\n30,0,35,180,\n",
    "few.csv": "# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,465nm,525nm\n30,0,30,180,1.92,2\n30,0,35,180,1.61,1.7\n30,0,95,180,1,1\n30,0,40,180,-0.1,\n",
}

# Command lines, without --json. "?" in front: the answer may be no (exit status 1).
RUNS = """
fit paint.csv
fit paint.csv --loss auto --model beckmann+lambert
fit paint.csv --channels each --max-theta 70 --shape axis
fit paint.csv --channels mean --profile --free ks
fit paint.csv --errors noise --cut-off 60
fit paint.csv --weight noise
fit paint.csv --reach 60 --cut-off 0
fit paint.csv --scale-uncertainty 0.02 --offset-uncertainty 0.05 --angle-uncertainty 0.1 --aperture 1 --aperture-uncertainty 0.05 --cut-off 0
fit grey.csv --reach 70
fit coarse.csv --reach 80
fit paint.csv --noise-model relative=0.02,floor=0.001,cos_i=-1
fit paint.csv --bootstrap 20 --cut-off 0 --seed 3
fit paint.csv --cut-off 60 --loss log --robust cauchy
fit paint.csv --robust huber:0.1
fit paint.csv --aperture 0.5x0.3 --source 0.1
fit paint.csv --shape axis --bound alpha=0.05:0.9,f0[r]=0:0.95 --prior f0=0.5+-0.2,alpha_x=0.3+-0.2 --tie kd,alpha_y=alpha_x --energy-conserving
fit paint.csv --fix f0[g]=0.45 --prior f0[r]=0.1+-0.0001
fit paint.csv --fix f0=0.4:0.5:0.6 --saturation 5 --noise-floor 0.01 --negative drop
fit paint.csv --bound kd=0.3:0.4
fit paint.csv --bound kd[r]=0.3:0.4 --shape isotropic --mean-slope
fit paint.csv --fix gamma=2 --model gtr+lambert
fit paint.csv --model lambert
fit paint.csv --model ggx
?fit paint.csv --model ggx+beckmann/v-cavity+lambert --max-iterations 1
fit grey.csv --free ks --tie f0=ks
fit sigma.csv
fit sigma.csv --noise-floor 2sigma --weight sample
fit exact.csv --loss relative
fit dark.csv --fix f0=0.5 --prior f0=0.4+-0.1
fit bright.csv --energy-conserving --free ks
fit many.csv --bound kd=0.2:0.3
fit many.csv --model ggx+oren-nayar --robust tukey
fit merl.binary --threads 1 --loss cube-root
fit grey.csv --model tabulated+lambert --ndf-table kept.tab
fit paint.csv --for blender:metal
fit grey.csv --for gltf --model beckmann/none
fit paint.csv --for usd --channels mean
fit grey.csv --for blender:dielectric --fix eta=1.5
fit paint.csv --for mitsuba:plastic --model ggx/v-cavity/schlick-f82+oren-nayar
compare grey.csv --for gltf,unreal
?gather library
export made.json --to blender -o out.py
export made.json --to gltf -o out.gltf
export made.json --to c -o out.h
export made.json --to merl -o out.binary
compare paint.csv --ndf beckmann,ggx --masking v-cavity,smith-height-correlated --cross-validate 3
compare grey.csv --ndf ggx,gtr --masking v-cavity --channels each --robust huber
compare grey.csv --ndf ggx --masking smith-separable,smith-height-correlated --reach 85
compare sigma.csv --ndf ggx --masking v-cavity --fresnel schlick,dielectric --diffuse lambert,none
ndf grey.csv
ndf paint.csv --smooth 10 --nodes 31 --monotone d --loss log
ndf bright.csv --max-theta 70
ndf sigma.csv
ndf peak.csv
?ndf grey.csv --max-iterations 1
ndf paint.csv --channels mean --masking v-cavity
info paint.csv
info merl.binary
info few.csv
info few.csv --quantity brdf-cos
info few.csv --quantity reflectance-factor
info nothing_usable.csv
info sigma.csv --reduce mean
info paint.csv --scale 100
resample paint.csv out.astm
resample grey.csv out.txt --to zemax --extrapolate
resample few.csv out.csv
eval ggx+lambert --set f0=0.1:0.2:0.3 --terms directions.csv
eval ggx+beckmann --terms directions.csv
eval lambert nothing.csv
furnace lambert --mu 1,0.5 --set kd=0.5
?furnace ggx+beckmann/v-cavity --weak --mu 1,0.5
sample ggx --set alpha=0.2,f0=0.1:0.2:0.3 --theta 45 -n 10
render ggx --set alpha=0.2,f0=0.1:0.2:0.3 --environment sky --samples 4 --size 4 -o ball.png
convert --from beckmann --to ggx m=0.5
convert --from beckmann --to phong m=0.9
convert --from ior --to f82-tint ior=1.5:1.3
convert --list
models
formats
""".strip().splitlines()

failures = []


def check(condition, what):
    if not condition:
        failures.append(what)


def strict(text, what):
    """JSON without NaN, Infinity and repeated keys."""
    def constant(name):
        raise ValueError("%s: not JSON: %s" % (what, name))

    def pairs(items):
        keys = [k for k, _ in items]
        if len(keys) != len(set(keys)):
            raise ValueError("%s: repeated key in %s" % (what, keys))
        return dict(items)
    return json.loads(text, parse_constant=constant, object_pairs_hook=pairs)


def says(*args, **how):
    return subprocess.run([PROGRAM, *args], capture_output=True, **how)


# ---- the schemas -----------------------------------------------------------------------------------------------------------------


class Schema:
    """docs/schema/<id>.schema.json; a place in it is a JSON pointer."""

    def __init__(self, id):
        self.id = id
        with open(os.path.join(SCHEMAS, id + ".schema.json"), encoding="utf-8") as file:
            self.text = file.read()
        self.root = strict(self.text, id)
        self.validator = Validator(self.root)
        self.met = set()    # places of keys and alternatives that a document had
        self.values = {}    # place of an enum: values that it had
        self.objects = {}   # place that describes an object: those met there, once for every set of keys
        self.valid_at = {}

    def at(self, reference):
        node = self.root
        for word in reference[2:].split("/"):
            node = node[word]
        return node

    def is_valid(self, schema, value):
        key = id(schema)
        if key not in self.valid_at:
            self.valid_at[key] = self.validator.evolve(schema=schema)
        return self.valid_at[key].is_valid(value)


def subschemas(node, place):
    """Every schema below and with node, with its place."""
    yield node, place
    for word in ("properties", "patternProperties", "$defs"):
        for key, value in node.get(word, {}).items():
            yield from subschemas(value, "%s/%s/%s" % (place, word, key))
    for word in ("additionalProperties", "propertyNames", "items"):
        if isinstance(node.get(word), dict):
            yield from subschemas(node[word], "%s/%s" % (place, word))
    for word in ("anyOf", "oneOf", "prefixItems"):
        for k, value in enumerate(node.get(word, [])):
            yield from subschemas(value, "%s/%s/%d" % (place, word, k))


def check_schema(s):
    Validator.check_schema(s.root)
    check(s.root["$schema"] == "https://json-schema.org/draft/2020-12/schema", "%s: $schema" % s.id)
    name = s.root["properties"]["schema"]["const"]
    check(s.root["$id"] == "urn:" + name.replace("facetfit.", "facetfit:").replace("/", ":"), "%s: $id is not that of %s" % (s.id, name))
    check(name.startswith("facetfit.%s/" % s.id), "%s: a document of another name, %s" % (s.id, name))
    used = set(re.findall(r'"\$ref": "([^"]*)"', s.text))
    unused = {"#/$defs/" + key for key in s.root.get("$defs", {})} - used
    check(not unused, "%s: nobody refers to %s" % (s.id, sorted(unused)))
    for reference in used:
        s.at(reference)
    for node, place in subschemas(s.root, "#"):
        for key, value in {**node.get("properties", {}), **node.get("patternProperties", {})}.items():
            check(len(value.get("description", "")) > 3, "%s%s: the key %s is not described" % (s.id, place, key))
        if node.get("type") == "object":
            check("additionalProperties" in node and node["additionalProperties"] is not True, "%s%s: open to any key" % (s.id, place))
            check(set(node.get("required", [])) <= set(node.get("properties", {})), "%s%s: a required key is not described" % (s.id, place))


def check_shared(schemas):
    """What has one name is one thing: the head of a document, and $defs of several."""
    seen = {}
    for s in schemas.values():
        head = {"head/" + key: s.root["properties"][key] for key in ("version", "command")}
        shared = {k: v for k, v in s.root.get("$defs", {}).items() if k in ("warning", "warning_code", "key", "name")}
        for key, value in {**head, **shared}.items():
            check(seen.setdefault(key, value) == value, "%s: its %s is not that of the other schemas" % (s.id, key))


def read_warnings():
    """{code: names of its values} of the registry."""
    with open(os.path.join(TOP, "fit", "warning", "ff_warnings.def"), encoding="utf-8") as file:
        lines = re.findall(r'^FF_WARNING\(\w+, "([^"]+)", \w+, "[^"]*", (.*)\)$', file.read(), re.M)
    return {code: re.findall(r'"(\w+)"', values) for code, values in lines}


# ---- documents -------------------------------------------------------------------------------------------------------------------


def prepare(directory):
    def make(item):
        p = says("simulate", *item[1].split(), "-o", item[0], cwd=directory, text=True)
        check(p.returncode == 0, "simulate %s: %s" % (item[0], p.stderr))
    for name, text in WRITTEN.items():
        with open(os.path.join(directory, name), "w") as file:
            file.write(text)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(make, FILES.items()))
    p = says("ndf", "grey.csv", "-o", "kept.tab", cwd=directory)
    check(p.returncode == 0, "ndf -o: %s" % p.stderr)
    p = says("fit", "paint.csv", "--json", "made.json", cwd=directory)
    check(p.returncode == 0, "fit --json: %s" % p.stderr)
    p = says("fit", "paint.csv", "grey.csv", "exact.csv", "nothing.csv", "-o", "library", "--shape", "isotropic", cwd=directory)
    check(p.returncode == 1, "fit -o: %s" % p.stderr)
    os.remove(os.path.join(directory, "library", "grey.csv.json"))


@functools.lru_cache(None)
def schema_id(*words):
    """Which schema --print-schema says the document of a command has."""
    p = says(*words, "--print-schema")
    check(p.returncode == 0 and not p.stderr, "%s --print-schema: status %d, %s" % (words[0], p.returncode, p.stderr))
    id = re.match(r"facetfit\.([a-z-]+)/", strict(p.stdout.decode(), words[0])["properties"]["schema"]["const"])[1]
    with open(os.path.join(SCHEMAS, id + ".schema.json"), "rb") as file:
        check(file.read() == p.stdout, "%s --print-schema is not docs/schema/%s.schema.json" % (words[0], id))
    return id


def run(line, directory):
    """(the line, which schema its document has, the document)"""
    words = line.lstrip("?").split()
    id = schema_id(words[0], *[w for w in words if w == "--list"])
    p = says(*words, "--json", "-", cwd=directory)
    if p.returncode not in ((0, 1) if line[0] == "?" else (0,)):
        failures.append("%s: status %d, %s" % (line, p.returncode, p.stderr.decode("utf-8", "replace")))
        return line, id, None
    return line, id, strict(p.stdout.decode("utf-8"), line)


def walk(s, node, value, place):
    """Notes what of the schema a valid document has."""
    site = node
    while "$ref" in node:
        place = node["$ref"]
        node = s.at(place)
    for word in ("anyOf", "oneOf"):
        for k, branch in enumerate(node.get(word, [])):
            if s.is_valid(branch, value):
                s.met.add("%s/%s/%d" % (place, word, k))
                walk(s, branch, value, "%s/%s/%d" % (place, word, k))
    if "enum" in node:
        s.values.setdefault(place, set()).add(value)
    if isinstance(value, dict):
        if node.get("type") == "object":
            s.objects.setdefault(place, {}).setdefault(tuple(sorted(value)), (site, value))
        for key, item in value.items():
            if key in node.get("properties", {}):
                below = "%s/properties/%s" % (place, key)
                s.met.add(below)
                walk(s, node["properties"][key], item, below)
                continue
            for pattern, pattern_node in node.get("patternProperties", {}).items():
                if re.search(pattern, key):
                    s.met.add("%s/patternProperties/%s" % (place, pattern))
                    walk(s, pattern_node, item, "%s/patternProperties/%s" % (place, pattern))
            if isinstance(node.get("additionalProperties"), dict):
                s.met.add(place + "/additionalProperties")
                walk(s, node["additionalProperties"], item, place + "/additionalProperties")
    if isinstance(value, list):
        first = node.get("prefixItems", [])
        for k, item in enumerate(value):
            if k < len(first):
                walk(s, first[k], item, "%s/prefixItems/%d" % (place, k))
            elif isinstance(node.get("items"), dict):
                s.met.add(place + "/items")
                walk(s, node["items"], item, place + "/items")


def check_document(s, line, d, warnings):
    errors = sorted(s.validator.iter_errors(d), key=lambda e: list(map(str, e.absolute_path)))
    for e in errors[:3]:
        failures.append("%s: %s: %s" % (line, "/".join(map(str, e.absolute_path)), e.message[:300]))
    if errors:
        return
    for fit in d.get("fits", []) + [d]:
        for w in fit.get("warnings", []):
            check(list(w["values"]) == warnings[w["code"]], "%s: values of %s: %s" % (line, w["code"], list(w["values"])))
    walk(s, s.root, d, "#")


def check_met(s):
    """Every key and alternative of the schema was met."""
    for node, place in subschemas(s.root, "#"):
        wanted = ["%s/%s/%s" % (place, word, key) for word in ("properties", "patternProperties") for key in node.get(word, {})]
        wanted += ["%s/%s/%d" % (place, word, k) for word in ("anyOf", "oneOf") for k in range(len(node.get(word, [])))]
        wanted += [place + "/additionalProperties"] * isinstance(node.get("additionalProperties"), dict)
        for key in wanted:
            check((key in s.met) != (s.id + key in NOT_MADE),
                  "%s%s: %s" % (s.id, key, "was met, and is listed as one that cannot be" if key in s.met else "no run has it"))


def unmet_values(s):
    """Values of enums that no run has: worth knowing, no failure."""
    for node, place in subschemas(s.root, "#"):
        rest = [v for v in node.get("enum", []) if v not in s.values.get(place, set())]
        if rest:
            yield "%s%s: %s" % (s.id, place, ", ".join(map(str, rest)))


# ---- planted mistakes ------------------------------------------------------------------------------------------------------------


def wrong(value):
    """Values of another type: an object, and a number as text."""
    yield {"planted": True}
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        yield str(value)


def plant(node, value):
    """(what, value with a mistake)"""
    yield "a key too many", {**value, "planted": {"planted": True}}
    for key in node.get("required", []):
        yield "without " + key, {k: v for k, v in value.items() if k != key}
    for key, item in value.items():
        for other in wrong(item):
            yield "%s: %s" % (key, other), {**value, key: other}


def check_planted(s):
    planted = 0
    for place, met in s.objects.items():
        for site, value in met.values():
            check(s.is_valid(site, value), "%s%s: an object of a valid document is not" % (s.id, place))
            for what, mistaken in plant(s.at(place) if place != "#" else s.root, value):
                planted += 1
                check(not s.is_valid(site, mistaken), "%s%s: %s was not found" % (s.id, place, what))
    return planted


def check_whole(s, d):
    """The same of a whole document, deep inside: what is checked of its parts is checked of it."""
    def objects(value, path):
        if isinstance(value, dict):
            yield path
        items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else []
        for key, item in items:
            yield from objects(item, path + [key])
    planted = 0
    for path in objects(d, []):
        mistaken = copy.deepcopy(d)
        node = mistaken
        for key in path:
            node = node[key]
        node["planted"] = {"planted": True}
        planted += 1
        check(not s.validator.is_valid(mistaken), "%s: a key too many in %s was not found" % (s.id, path))
    return planted


# ---- docs/json.md ----------------------------------------------------------------------------------------------------------------


def check_page(schemas, directory):
    """Its commands run one after another, its Python reads what they wrote, its table has every document."""
    with open(os.path.join(TOP, "docs", "json.md"), encoding="utf-8") as file:
        page = file.read()
    names = {s.root["properties"]["schema"]["const"] for s in schemas.values()}
    check(set(re.findall(r"`(facetfit\.[a-z-]+/\d+)`", page)) == names, "docs/json.md: the documents are %s" % sorted(names))
    lines = re.findall(r"^    ((?:facetfit|jq|python3) .*)$", page, re.M)
    lines = [line.replace("python3", sys.executable, 1) for line in lines if "jq " not in line or shutil.which("jq")]
    where = {"cwd": directory, "capture_output": True, "text": True,
             "env": dict(os.environ, PATH=os.path.dirname(PROGRAM) + os.pathsep + os.environ["PATH"])}
    for line in lines:
        p = subprocess.run(["sh", "-c", line], **where)
        check(p.returncode == 0 and not p.stderr, "docs/json.md: %s: %s" % (line, p.stderr))
    script = re.search(r"^    import json\n(?:    .*\n)+", page, re.M)[0].replace("\n    ", "\n").lstrip()
    p = subprocess.run([sys.executable, "-c", script], **where)
    check(len(lines) >= 5 and p.stdout.startswith("converged 0.30"), "docs/json.md: the Python says %s%s" % (p.stdout, p.stderr))


# ---- the test --------------------------------------------------------------------------------------------------------------------


def check_commands():
    """A command that writes JSON has a schema, and no other has; every file is one of a command."""
    commands = re.findall(r"^  (\w+) ", says("--help", text=True).stdout, re.M)
    check(len(commands) >= 13, "commands %s" % commands)
    with_json = []
    for command in commands:
        text = says(command, "--help", text=True).stdout
        check(("--json" in text) == ("--print-schema" in text), "%s: --json and --print-schema go together" % command)
        with_json += [command] if "--json" in text else []
    run_of = {line.lstrip("?").split()[0] for line in RUNS}
    check(set(with_json) == run_of, "commands with --json: %s, and runs of: %s" % (sorted(with_json), sorted(run_of)))


def main():
    ids = sorted(name[:-len(".schema.json")] for name in os.listdir(SCHEMAS))
    schemas = {id: Schema(id) for id in ids}
    warnings = read_warnings()
    for s in schemas.values():
        check_schema(s)
        if "warning_code" in s.root.get("$defs", {}):
            check(s.root["$defs"]["warning_code"]["enum"] == list(warnings), "%s: warning_code is not the list of ff_warnings.def" % s.id)
    check_shared(schemas)
    check_commands()
    with tempfile.TemporaryDirectory() as directory:
        prepare(directory)
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            documents = list(pool.map(lambda line: run(line, directory), RUNS))
        check_page(schemas, directory)
    check({id for _, id, _ in documents} == set(ids), "no command prints %s" % (set(ids) - {id for _, id, _ in documents}))
    for line, id, d in documents:
        if d is not None:
            check_document(schemas[id], line, d, warnings)
    planted = 0
    for s in schemas.values():
        check_met(s)
        planted += check_planted(s)
        planted += check_whole(s, min((d for _, id, d in documents if id == s.id and d), key=lambda d: len(json.dumps(d)), default={}))
        for text in unmet_values(s):
            print("no run has", text)
    for failure in failures:
        print("failed:", failure)
    print("%d schemas, %d documents, %d planted mistakes, %d failures" % (len(schemas), len(documents), planted, len(failures)))
    return 1 if failures or planted < 1000 else 0


sys.exit(main())
