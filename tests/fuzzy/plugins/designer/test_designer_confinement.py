"""No path leads a document out of its folder, and what cannot be opened or kept gives a sentence."""

from pathlib import Path

import pytest

import fuzzy
from fuzzy.files.fisfile import write_quietly
from fuzzy.plugins.designer.document import Document, confined
from fuzzy.plugins.designer.saving import DocumentError
from tests.fuzzy.plugins.designer.design_messages import near, system, unsaved


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def test_no_path_leads_out_of_the_folder(tmp_path, file):
    outside = tmp_path / "secret.fis"
    write_quietly(system(name="secret"), outside)
    (file.parent / "link.fis").symlink_to(outside)
    (file.parent / "way").symlink_to(tmp_path)
    (file.parent / "ring.fis").symlink_to(file.parent / "ring.fis")
    before = tree(tmp_path)
    document = Document(file)
    bad = ["../secret.fis", str(outside), "link.fis", "way/secret.fis", "way/new.fis", "ring.fis", "demo.txt", ".fis"]
    bad += ["", ".", ".fuzzy-design/x.fis", "a\0.fis", "sub/../../secret.fis", "x" * 5000 + ".fis", "nowhere/x.fis"]
    for path in bad:
        for overwrite in (False, True):
            with pytest.raises(fuzzy.InputError):
                document.save(path, overwrite)
        with pytest.raises(fuzzy.InputError):
            Document(path, file.parent)
    assert tree(tmp_path) == before
    assert confined(file.parent, file) == file


def test_a_file_that_becomes_a_link_is_not_followed_out(tmp_path, file):
    outside = tmp_path / "outside.fis"
    outside.write_text("left alone")
    document = Document(file)
    document.apply(near(0.5))
    file.unlink()
    file.symlink_to(outside)
    for refused in (document.save, document.discard):
        with pytest.raises(DocumentError, match="outside the opened folder"):
            refused()
    document.path.unlink()
    (file.parent / ".fuzzy-design").mkdir()
    unsaved(file).symlink_to(outside)
    document.autosave()
    assert not unsaved(file).is_symlink()
    assert outside.read_text() == "left alone"


def test_a_linked_folder_for_unsaved_work_is_refused(tmp_path, file):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (file.parent / ".fuzzy-design").symlink_to(elsewhere)
    document = Document(file)
    document.apply(near(0.5))
    with pytest.raises(DocumentError, match="leads out of the opened folder"):
        document.autosave()
    assert not list(elsewhere.iterdir())


def test_a_file_where_the_folder_should_be_gives_a_sentence(file):
    (file.parent / ".fuzzy-design").write_text("")
    document = Document(file)
    document.apply(near(0.5))
    with pytest.raises(DocumentError, match="unsaved work cannot be kept in"):
        document.autosave()


def test_a_malformed_file_gives_the_readers_sentence(file):
    file.write_text("[System]\nName='x'\nType='mamdani'\n")
    with pytest.raises(fuzzy.FisFileError, match=r"demo.fis:3: this is a Mamdani system"):
        Document(file)
    (file.parent / "folder.fis").mkdir()
    with pytest.raises(DocumentError, match="is not a file"):
        Document("folder.fis", file.parent)
