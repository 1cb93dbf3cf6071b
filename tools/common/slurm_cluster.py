# SPDX-License-Identifier: Apache-2.0
"""Starts a Slurm cluster of two one-core nodes on this machine, for tests and measurements, and a third node in a partition that
nobody asks for. It has its own key, configuration, ports and state in a temporary folder, and daemons that end with the process
that started them, whatever becomes of it.

    with Cluster() as cluster:
        subprocess.run(["sbatch", ...], env=cluster.environment)

Slurm's daemons need root (they start tasks as other users). missing() says why no cluster can be
started, or returns None."""
import atexit
import ctypes
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time

LIBC = ctypes.CDLL(None)
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue", "scontrol", "scancel")
CONFIGURATION = """\
ClusterName=eikon_test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/munge.sock
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldPort={ports[0]}
SlurmctldParameters=enable_configless
ReturnToService=2
MpiDefault=none
KillWait=2
MaxArraySize=5
SchedulerParameters=sched_interval=2,batch_sched_delay=0
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=1 RealMemory=4000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=1 RealMemory=4000
NodeName=n3 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[3]} CPUs=1 RealMemory=4000
PartitionName=other Nodes=n3 State=UP
PartitionName=work Nodes=n1,n2 Default=YES State=UP
"""


def missing():
    """Returns a line that says why no cluster can be started here, or None."""
    path = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
    absent = [name for name in PROGRAMS if not shutil.which(name, path=path)]
    if absent:
        return f"Slurm is not installed: there is no {', '.join(absent)}"
    if os.geteuid() != 0:
        return "Slurm's daemons cannot be started by another user than root"
    return None


def free_ports(count):
    """Returns numbers of ports that nothing listens on."""
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def wait_until(condition, seconds, what):
    """Returns the first true result of the condition; raises TimeoutError after so many seconds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if result := condition():
            return result
        time.sleep(0.1)
    raise TimeoutError(f"waited {seconds} s for {what}")


def end_with_parent():
    """Lets the kernel end a daemon when its parent is gone: ctest kills a test that takes too long by SIGKILL."""
    PR_SET_PDEATHSIG = 1
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


class Cluster:
    """Use it in a `with` statement. hidden: a folder that node n2 does not see, as if it were not shared."""

    def __init__(self, hidden=None):
        self.hidden = hidden
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="eikon_slurm_"))
        self.folder.chmod(0o755)  # munged wants a path that all may pass
        self.daemons = []
        self.environment = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"),
                                PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")
        atexit.register(self.stop)

    def __enter__(self):
        # An interrupted test ends as by Ctrl-C, so that the daemons are stopped.
        for interrupt in (signal.SIGTERM, signal.SIGINT):
            signal.signal(interrupt, signal.default_int_handler)
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def daemon(self, name, command):
        """Starts a daemon in a session of its own; what it says goes to its log."""
        with open(self.folder / f"{name}.log", "ab") as log:
            self.daemons.append(subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=log,
                                                 stderr=log, start_new_session=True, preexec_fn=end_with_parent))

    def start(self):
        for name in ("munge", "state", "spool/n1", "spool/n2", "spool/n3"):
            (self.folder / name).mkdir(parents=True)
        key = self.folder / "munge/munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=socket.gethostname().split(".")[0], folder=self.folder, ports=free_ports(4)))
        munge = self.folder / "munge"
        self.daemon("munged", ["munged", "-F", "--force", f"--key-file={key}", f"--socket={munge}/munge.sock",
                               f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed"])
        wait_until((munge / "munge.sock").exists, 20, "munged")
        self.daemon("slurmctld", ["slurmctld", "-D", "-i"])
        for name in ("n1", "n3"):
            self.daemon(name, ["slurmd", "-D", "-N", name])
        n2 = ["slurmd", "-D", "-N", "n2"]
        if self.hidden:
            n2 = ["unshare", "--mount", "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(self.hidden), *n2]
        self.daemon("n2", n2)
        wait_until(lambda: self.run("sinfo", "-h", "-N", "-o", "%t").split() == ["idle"] * 3, 40, "idle nodes")

    def run(self, *command):
        """Runs a command in the cluster's environment and returns what it prints on stdout; it may fail."""
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False).stdout

    def stop(self):
        """Ends the tasks and the daemons, by the numbers of the processes that were started."""
        if not self.folder.exists():
            return
        if len(self.daemons) > 1:
            self.run("scancel", "--user=root")
            time.sleep(0.3)
        for end in (signal.SIGTERM, signal.SIGKILL):
            for daemon in reversed(self.daemons):
                if daemon.poll() is None:
                    daemon.send_signal(end)
            stop = time.monotonic() + 5
            while time.monotonic() < stop and any(d.poll() is None for d in self.daemons):
                time.sleep(0.05)
        shutil.rmtree(self.folder, ignore_errors=True)
