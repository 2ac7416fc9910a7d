#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""hybrid-experiment under srun and sbatch: slurm_test.py BIN, with BIN the folder of the programs.

Starts Slurm with this machine as its only node, as the present user and in a temporary folder, and ends it. Skipped
(77) where Slurm is not installed or does not start.
"""

import csv
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

HOST = socket.gethostname().split(".")[0]
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CONFIG = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
SelectType=select/cons_tres
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=10 State=UP OverSubscribe=YES
"""
EXPERIMENT = """[experiment]
data_dir = .
graphs = a
methods = gnc dcs
outlier_rates = 0 0.4
trials = 4

[a]
file = a.g2o
"""
TIMES = (7, 8)  # columns of the ledger


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Cluster:
    """Slurm on this machine, in a folder."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = []
        for name in ("state", "spool"):
            os.mkdir(os.path.join(folder, name))
        config = os.path.join(folder, "slurm.conf")
        with open(config, "w") as out:
            user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
            out.write(CONFIG.format(host=HOST, user=user, folder=folder, ports=free_ports(2)))
        self.env = {**os.environ, "SLURM_CONF": config, "OMPI_ALLOW_RUN_AS_ROOT": "1",
                    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}

    def __enter__(self):
        for command in (["slurmctld", "-D"], ["slurmd", "-D", "-N", HOST]):
            log = open(os.path.join(self.folder, command[0] + ".out"), "w")
            self.daemons.append(subprocess.Popen(command, env=self.env, stdout=log, stderr=log))
        for _ in range(100):
            time.sleep(0.3)
            if any(daemon.poll() is not None for daemon in self.daemons):
                break
            state = self.run("sinfo", "-h", "-o", "%t")
            if state.returncode == 0 and state.stdout.strip() in ("idle", "mix", "alloc"):
                return self
        said = ""
        for name in ("slurmctld.out", "slurmd.out", "slurmctld.log", "slurmd.log"):
            path = os.path.join(self.folder, name)
            if os.path.exists(path):
                said += open(path).read()[-1000:]
        self.__exit__()
        skip(f"Slurm does not start here:\n{said}")

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            if daemon.poll() is None:
                daemon.send_signal(signal.SIGTERM)
        for daemon in self.daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def run(self, *command, timeout=240):
        return subprocess.run(command, env=self.env, cwd=self.folder, capture_output=True, text=True, timeout=timeout)


def rows(folder):
    """The rows of the ledger, without times."""
    with open(os.path.join(folder, "results.csv")) as table:
        return sorted([x for i, x in enumerate(row) if i not in TIMES] for row in csv.reader(table))


def write_experiment(folder):
    with open(os.path.join(folder, "a.g2o"), "w") as graph:
        for k in range(1, 40):
            graph.write(f"EDGE_SE2 {k - 1} {k} 1 0.01 0.02 400 0 0 400 0 2500\n")
            if k >= 3:
                graph.write(f"EDGE_SE2 {k - 3} {k} 3 0 0.05 400 0 0 400 0 2500\n")
    with open(os.path.join(folder, "e.ini"), "w") as ini:
        ini.write(EXPERIMENT)


def check_srun(cluster, program, expected):
    for ranks in ("2", "3"):
        ran = cluster.run("srun", "--mpi=pmix", "-n", ranks, program, "-c", "e.ini", "-o", "of" + ranks)
        assert ran.returncode == 0, ran.stdout + ran.stderr
        assert rows(os.path.join(cluster.folder, "of" + ranks)) == expected


def check_job_script(cluster, expected):
    script = os.path.join(SOURCE, "config/cluster/experiment.sbatch")
    ran = cluster.run("sbatch", "--wait", "--nodes=1", "--ntasks-per-node=3", "--time=5", script, "e.ini", "job")
    log = "".join(open(os.path.join(cluster.folder, name)).read()
                  for name in os.listdir(cluster.folder) if name.startswith("slurm-"))
    assert ran.returncode == 0, ran.stdout + ran.stderr + log
    assert rows(os.path.join(cluster.folder, "job")) == expected


def main():
    programs = os.path.abspath(sys.argv[1])
    program = os.path.join(programs, "hybrid-experiment")
    os.environ["PATH"] = os.pathsep.join([programs, os.environ["PATH"], "/usr/sbin"])
    for name in ("slurmctld", "slurmd", "srun", "mpirun"):
        if shutil.which(name) is None:
            skip(f"{name} is not installed")
    if "libmpi" not in subprocess.run(["ldd", program], capture_output=True, text=True).stdout:
        skip("hybrid-experiment was built without MPI")
    with tempfile.TemporaryDirectory() as folder:
        write_experiment(folder)
        alone = subprocess.run([program, "-c", "e.ini", "-o", "one"], cwd=folder, capture_output=True, text=True)
        assert alone.returncode == 0, alone.stdout + alone.stderr
        expected = rows(os.path.join(folder, "one"))
        assert len(expected) == 1 + 2 * 5, expected
        with Cluster(folder) as cluster:
            if "pmix" not in cluster.run("srun", "--mpi=list").stderr + cluster.run("srun", "--mpi=list").stdout:
                skip("Slurm has no pmix plugin")
            check_srun(cluster, program, expected)
            check_job_script(cluster, expected)


if __name__ == "__main__":
    main()
