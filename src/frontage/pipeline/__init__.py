"""From files to a run folder: the project, the stages in order, and the folder's answers."""
