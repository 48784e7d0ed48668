#!/usr/bin/env python3
"""cluster_test.py PROGRAM SOURCE_DIR slurm|parallel|snakemake: what docs/cluster.md says of an engine runs, as it stands there, and
makes the bytes of a run without it. Skipped where the engine is not installed; ./setup cluster installs all three.

slurm: a node of this machine alone, with a key, a state and ports of its own, on loopback; an array of 8 of which one is lost on purpose,
found missing, submitted again and gathered."""
import os
import re
import shutil
import signal
import subprocess
import sys
import time

from batches import Library

PROGRAM, TOP, ENGINE = sys.argv[1:4]
TOOLS = {"slurm": ["sbatch", "sinfo", "squeue", "scancel", "slurmctld", "slurmd", "munged"], "parallel": ["parallel"], "snakemake": ["snakemake"]}
FILES = 20


def page():
    with open(os.path.join(TOP, "docs", "cluster.md"), encoding="utf-8") as f:
        return f.read()


def block_after(mark):
    """The indented lines after a mark of the page."""
    rest = page().split(mark, 1)[1].split("\n\n", 1)[1]
    lines = []
    for line in rest.splitlines():
        if line.startswith("    ") or not line.strip():
            lines.append(line[4:])
        else:
            break
    return "\n".join(lines).strip() + "\n"


def section(title):
    return re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", page(), re.M | re.S)[1]


def shell(lines, **more):
    folder = os.path.dirname(os.path.abspath(PROGRAM))
    environment = {**os.environ, "LC_ALL": "C", "PATH": folder + os.pathsep + os.environ["PATH"], "HOME": lib.folder, **more}
    return subprocess.run(["bash", "-ec", lines], cwd=lib.folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          check=False, timeout=240)


def same_as_without(what):
    lib.run("fit", "library", "-o", "alone", "--summary", "alone.csv", expected=0)
    lib.check(lib.results("fits") == lib.results("alone") and len(lib.results("alone")) == FILES, f"{what}: other results")
    lib.check(os.path.exists(lib.at("library.csv")) and lib.read("library.csv") == lib.read("alone.csv"), f"{what}: another summary")


def parallel():
    lines = [line.strip() for line in section("GNU parallel").splitlines() if line.startswith("    ")]
    lib.check(len(lines) == 2 and "parallel" in lines[0] and "gather" in lines[1], f"the page has {lines}")
    done = shell("\n".join(lines))
    lib.check(done.returncode == 0, f"parallel: {done.returncode}, {done.stderr[-800:]}")
    same_as_without("GNU parallel")


def snakemake():
    lib.write("Snakefile", block_after("<!-- file: Snakefile -->").encode())
    done = shell("snakemake --cores 2 --nolock", XDG_CACHE_HOME=lib.at("cache"))
    lib.check(done.returncode == 0, f"snakemake: {done.returncode}, {done.stderr[-1500:]}")
    same_as_without("Snakemake")


CONF = """ClusterName=batch
SlurmctldHost={node}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={other}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={at}/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
StateSaveLocation={at}/state
SlurmdSpoolDir={at}/spool
SlurmctldPidFile={at}/slurmctld.pid
SlurmdPidFile={at}/slurmd.pid
SlurmctldLogFile={at}/slurmctld.log
SlurmdLogFile={at}/slurmd.log
NodeName={node} NodeAddr=127.0.0.1 CPUs=2 Boards=1 SocketsPerBoard=2 CoresPerSocket=1 ThreadsPerCore=1 State=UNKNOWN
PartitionName=all Nodes={node} Default=YES State=UP
"""


def wait_for(holds, seconds):
    limit = time.monotonic() + seconds
    while time.monotonic() < limit:
        if holds():
            return True
        time.sleep(0.2)
    return False


def start_cluster(children):
    """The daemons, as children of this process; the environment that finds them."""
    os.chmod(lib.folder, 0o755)
    for name in ("munge", "state", "spool"):
        os.mkdir(lib.at(name), 0o755)
    with open(os.open(lib.at("key"), os.O_WRONLY | os.O_CREAT, 0o600), "wb") as key:
        key.write(os.urandom(1024))
    node, port = os.uname().nodename.split(".")[0], 20000 + os.getpid() % 20000
    lib.write("slurm.conf", CONF.format(node=node, port=port, other=port + 1, at=lib.folder).encode())
    environment = {"SLURM_CONF": lib.at("slurm.conf")}
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, **environment}}
    munge = ["munged", "--foreground", "--force"] + [f"--{what}={lib.at(where)}" for what, where in (
        ("key-file", "key"), ("socket", "munge/socket"), ("pid-file", "munge/pid"), ("log-file", "munge/log"), ("seed-file", "munge/seed"))]
    children.append(subprocess.Popen(munge, **quiet))
    wait_for(lambda: os.path.exists(lib.at("munge", "socket")), 10)
    children.append(subprocess.Popen(["slurmctld", "-D", "-f", lib.at("slurm.conf")], **quiet))
    children.append(subprocess.Popen(["slurmd", "-D", "-f", lib.at("slurm.conf"), "-N", node], **quiet))
    idle = wait_for(lambda: shell("sinfo -h -o %t", **environment).stdout.strip() == "idle", 60)
    lib.check(idle, "the node is not idle after a minute")
    return environment if idle else None


def over(environment):
    return wait_for(lambda: not shell("squeue -h", **environment).stdout.strip(), 150)


def run_array(environment):
    lib.write("library.sbatch", block_after("<!-- file: library.sbatch -->").encode())
    lost = shell("array=$(sbatch --parsable --hold library.sbatch); scancel ${array}_3; scontrol release $array; echo $array", **environment)
    lib.check(lost.returncode == 0, f"sbatch: {lost.stderr}")
    lib.check(over(environment), "the array is not over")
    done = shell("facetfit gather fits --summary library.csv", **environment)
    missing = re.findall(r"^(library/m\d+\.csv): missing$", done.stdout, re.M)
    expected = [f"library/m{i:04}.csv" for i in range(2, FILES, 8)]
    lib.check(done.returncode == 1 and missing == expected, f"of a lost shard is missing: {done.returncode}, {missing}: {done.stdout}{done.stderr}")
    os.remove(lib.at("library.csv"))
    summary = re.search(r"^    sbatch (--dependency=.*)$", section("Slurm"), re.M)[1]
    again = shell(f"array=$(sbatch --parsable --array=3 library.sbatch)\nsbatch {summary}", **environment)
    lib.check(again.returncode == 0, f"sbatch --array=3: {again.stderr}")
    lib.check(over(environment), "the second array is not over")
    lib.check(b"20 done" in lib.read("gather.log"), f"gather in the array: {lib.read('gather.log')}")
    same_as_without("Slurm")


def slurm():
    if os.getuid() != 0:
        print("skipped: not root, as which a node's daemon runs")
        sys.exit(77)
    children = []
    try:
        environment = start_cluster(children)
        if environment:
            run_array(environment)
        if lib.failed:
            for log in ("slurmctld.log", "slurmd.log", "munge/log", "library-1.log"):
                if os.path.exists(lib.at(log)):
                    print(f"== {log}\n" + lib.read(log).decode(errors="replace")[-1500:])
    finally:
        for child in reversed(children):
            child.send_signal(signal.SIGTERM)
        for child in children:
            try:
                child.wait(20)
            except subprocess.TimeoutExpired:
                child.kill()


missing_tools = [tool for tool in TOOLS[ENGINE] if not shutil.which(tool)]
if missing_tools:
    print(f"skipped: {missing_tools[0]} is not there; ./setup cluster would install it")
    sys.exit(77)
lib = Library(PROGRAM)
lib.fill(FILES, "library")
{"slurm": slurm, "parallel": parallel, "snakemake": snakemake}[ENGINE]()
sys.exit(lib.end())
