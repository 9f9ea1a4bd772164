"""The designer: a rule base under design in the browser or a notebook.

:mod:`fuzzy.designer.design` is what is designed, :mod:`fuzzy.designer.edits` how a message changes it,
:mod:`fuzzy.designer.views` what is shown of it, :mod:`fuzzy.designer.document` the file that it belongs to. These
need nothing but numpy; the page needs the extra ``design``.
"""
