"""Paths that do not work, and files that appear whole or not at all."""

import os
from pathlib import Path

import pytest

from subdfit.errors import InputError, MachineError
from subdfit.io import check_writable, read, write
from subdfit.io.atomic import atomic


@pytest.mark.parametrize(
    "name", ["none.obj", "folder.ply", "empty.ply", "a.docx", "plain", "bad\0name.obj", "x" * 300 + ".obj"]
)
def test_reading_what_cannot_be_read(tmp_path, name):
    (tmp_path / "folder.ply").mkdir()
    for made in ("empty.ply", "a.docx", "plain"):
        (tmp_path / made).touch()
    with pytest.raises(InputError) as caught:
        read(tmp_path / name)
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may read everything")
def test_reading_without_permission(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0")
    (tmp_path / "a.obj").chmod(0)
    with pytest.raises(InputError, match="permission"):
        read(tmp_path / "a.obj")


def test_pipe_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(InputError, match="regular file"):
        read(tmp_path / "a.obj")


def test_failure_keeps_the_old_file_and_leaves_nothing(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")

    def fail_halfway() -> None:
        with atomic(target) as stream:
            stream.write(b"new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail_halfway()
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_success_replaces_the_file_behind_a_link(tmp_path):
    (tmp_path / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("real.txt")
    with atomic(tmp_path / "link.txt") as stream:
        stream.write(b"new")
    assert (tmp_path / "real.txt").read_text() == "new"
    assert (tmp_path / "link.txt").is_symlink()


@pytest.mark.parametrize("call", [check_writable, "write"])
def test_places_that_cannot_be_written(tmp_path, tetrahedron, call):
    def attempt(path):
        return write(path, tetrahedron) if call == "write" else call(path)

    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"files of type \.doc"):
        attempt(tmp_path / "a.doc")
    bad = ["none/a.obj", "folder.obj", "file/a.obj", "x" * 300 + ".obj", "x" * 300 + "/a.obj"]
    for path in (tmp_path / name for name in bad):
        with pytest.raises(MachineError, match="cannot write") as caught:
            attempt(path)
        assert "\n" not in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.obj"]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a file system that takes no files")
def test_a_folder_that_takes_no_files_is_not_said_to_be_missing():
    with pytest.raises(MachineError, match="no file can be made in /proc; choose another folder"):
        check_writable("/proc/a.obj")


def test_a_fine_place_stays_empty(tmp_path):
    check_writable(tmp_path / "a.obj")
    assert not list(tmp_path.iterdir())
