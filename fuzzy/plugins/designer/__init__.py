"""The designer: a rule base under design in the browser or a notebook.

:mod:`fuzzy.plugins.designer.design` is what is designed, :mod:`fuzzy.plugins.designer.edits` how a message changes it,
:mod:`fuzzy.plugins.designer.views` what is shown of it, :mod:`fuzzy.plugins.designer.document` the file that it belongs
to. These need nothing but numpy; the page needs the extra ``design``.
"""
