"""`python -P -m stiffcal`: the same as the `stiffcal` command.

Without ``-P`` Python looks for modules in the current folder first, which may be somebody else's campaign. What can
still be done about that here is done before anything else is imported.
"""

from stiffcal.module_path import leave_out_current_folder

if __name__ == "__main__":
    leave_out_current_folder(started_by_name=True)

    from stiffcal.cli.app import main

    main()
