"""A batch on the executors of other packages, with workers that die, and in a store of objects."""

import concurrent.futures
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading

import chasles
import pytest

OPTIONS = ["--no-check", "--most-sigma", "1"]
NAMES = "abcdefgh"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    for name in NAMES:
        code = chasles.command("simulate", "turntable", "--set", "revolutions=0.15", "--quiet", "--run", ord(name), "-o",
                               folder / name)
        assert code == 0
    return [folder / name for name in NAMES]


def files(folder):
    root = pathlib.Path(folder)
    return {str(file.relative_to(root)): file.read_bytes() for file in sorted(root.rglob("*"))
            if file.is_file() and "timing" not in str(file.relative_to(root))}


@pytest.fixture(scope="module")
def expected(recordings, tmp_path_factory):
    return files(chasles.batch(recordings, tmp_path_factory.mktemp("here") / "batch", options=OPTIONS).folder)


def test_dask_and_a_worker_that_is_killed(recordings, expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            killed = []

            def kill_one(record):
                if not killed:
                    worker = next(iter(cluster.workers.values()))
                    killed.append(worker.pid)
                    os.kill(worker.pid, signal.SIGKILL)

            batch = chasles.batch(recordings, tmp_path / "dask", options=OPTIONS, on_record=kill_one,
                                  executor=client.get_executor())
    assert killed and batch.names("use") == list(NAMES)
    assert files(batch.folder) == expected


def test_a_study_on_dask(tmp_path):
    distributed = pytest.importorskip("distributed")
    filters, scene = {"ours": {}, "standard": {"chart": "standard"}}, {"revolutions": 0.12}
    here = chasles.monte_carlo("turntable", filters, runs=20, folder=tmp_path / "here", **scene)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            killer = threading.Timer(0.5, lambda: os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL))
            killer.start()
            there = chasles.monte_carlo("turntable", filters, runs=20, folder=tmp_path / "there",
                                        executor=client.get_executor(), **scene)
            killer.join()
    assert files(here.folder) == files(there.folder)


def test_processes_whose_executor_breaks(recordings, expected, tmp_path):
    def kill_one(record):
        if kill_one.wanted:
            kill_one.wanted = False
            os.kill(next(iter(executor._processes)), signal.SIGKILL)

    kill_one.wanted = True
    folder = tmp_path / "pool"
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        with pytest.raises(chasles.InputError, match="resume=True"):
            chasles.batch(recordings, folder, options=OPTIONS, executor=executor, on_record=kill_one)
    with concurrent.futures.ProcessPoolExecutor(2) as executor:
        chasles.batch(recordings, folder, options=OPTIONS, executor=executor, resume=True)
    assert files(folder) == expected


def test_ray(recordings, expected, tmp_path):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        batch = chasles.batch(recordings, tmp_path / "ray", options=OPTIONS, executor=chasles.RayExecutor(num_cpus=1))
    finally:
        ray.shutdown()
    assert files(batch.folder) == expected


# mpiexec starts the client and its workers, as the job of a cluster does.
MPI = """
import sys
import chasles
from mpi4py.futures import MPIPoolExecutor

if __name__ == "__main__":
    with MPIPoolExecutor() as executor:
        folder, *recordings = sys.argv[1:]
        print(chasles.batch(recordings, folder, options=["--no-check", "--most-sigma", "1"], executor=executor))
"""


@pytest.mark.skipif(shutil.which("mpiexec") is None, reason="no mpiexec")
def test_mpi(recordings, expected, tmp_path):
    pytest.importorskip("mpi4py")
    script = tmp_path / "job.py"
    script.write_text(MPI)
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(["mpiexec", "--oversubscribe", "-n", "3", sys.executable, "-m", "mpi4py.futures", script,
                           tmp_path / "mpi", *recordings], capture_output=True, text=True, timeout=120, env=environment)
    assert "<chasles.Batch of 8: 8 use, 0 check, 0 no>" in done.stdout, done.stderr
    assert files(tmp_path / "mpi") == expected


def test_a_store_of_objects(recordings, expected, tmp_path, monkeypatch):
    pytest.importorskip("s3fs")
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    try:
        host, port = server.get_host_and_port()
        for name, value in {"AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test", "AWS_DEFAULT_REGION": "us-east-1",
                            "AWS_ENDPOINT_URL": f"http://{host}:{port}"}.items():
            monkeypatch.setenv(name, value)
        import s3fs

        store = s3fs.S3FileSystem()
        store.mkdir("data")
        for recording in recordings[:3]:
            store.put(str(recording), f"data/in/{recording.name}", recursive=True)
        urls = [f"s3://data/in/{recording.name}" for recording in recordings[:3]]
        batch = chasles.batch(urls, "s3://data/out", options=OPTIONS, cache=tmp_path / "cache")
        assert batch.names("use") == ["a", "b", "c"]
        store.invalidate_cache()
        for name, data in expected.items():
            if name.startswith(("runs/a/", "runs/b/", "runs/c/")):
                assert store.cat(f"data/out/{name}") == data, name
        assert b"s3://data/in/b" in store.cat("data/out/page.html")
    finally:
        server.stop()


def test_a_recording_in_a_zip(recordings, expected, tmp_path):
    pytest.importorskip("fsspec")
    archive = shutil.make_archive(str(tmp_path / "all"), "zip", recordings[0].parent, "a")
    batch = chasles.batch([f"zip://a::file://{archive}"], tmp_path / "out", options=OPTIONS, cache=tmp_path / "cache")
    assert batch.names("use") == ["a"]
    assert pathlib.Path(batch.folder, "runs/a/states.csv").read_bytes() == expected["runs/a/states.csv"]


CLIENT = """
import contextlib
import sys
import chasles
import concurrent.futures

@contextlib.contextmanager
def executor(name):
    if name == "processes":
        with concurrent.futures.ProcessPoolExecutor(2) as pool:
            yield pool
        return
    import distributed
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client.get_executor()

if __name__ == "__main__":
    name, folder, *recordings = sys.argv[1:]
    with executor(name) as one:
        chasles.batch(recordings, folder, options=["--no-check", "--most-sigma", "1"], executor=one, resume=True)
    print("complete")
"""


# Again and again at another moment, with its workers and Dask's scheduler, until a client gets to the end.
@pytest.mark.parametrize("executor, moments", [("processes", (1.0, 1.3, 1.6, 1.9, 2.2)), ("dask", (3.0, 3.5, 4.0, 4.5))])
def test_client_scheduler_and_workers_are_killed_at_any_time(executor, moments, recordings, expected, tmp_path):
    if executor == "dask":
        pytest.importorskip("distributed")
    script = tmp_path / "client.py"
    script.write_text(CLIENT)
    command = [sys.executable, str(script), executor, str(tmp_path / "out"), *map(str, recordings)]
    for seconds in moments:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        killer = threading.Timer(seconds, lambda: os.killpg(process.pid, signal.SIGKILL))
        killer.start()
        process.wait()
        killer.cancel()
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert "complete" in done.stdout, done.stderr
    assert files(tmp_path / "out") == expected
