"""The stable code of every fault: which family it belongs to, whatever its words are.

Programs that start stiffcal, and the documentation, go by the code; its words may change from version to version.
"""

from __future__ import annotations

from enum import StrEnum


class FaultCode(StrEnum):
    """A family of faults; its value stands in ``error.code`` of the JSON documents and at the end of the line."""

    covers: str
    """One line: what the family's faults have in common."""

    def __new__(cls, value: str, covers: str = "") -> FaultCode:
        """Make a member of its value and what it covers."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.covers = covers
        return member

    # The command line and the surroundings.
    COMMAND_LINE = "command-line", "A command, an option or an argument that the command does not have."
    OPTION_MISSING = "option-missing", "An option without which the command cannot know what to do."
    OPTION_INVALID = "option-invalid", "A value of an option or an environment variable that is not possible."
    OPTION_CONFLICT = "option-conflict", "Options that exclude each other, or that go with other options only."
    LIBRARY_MISSING = "library-missing", "A library or an installed package that is absent or cannot be imported."
    SYSTEM_REFUSAL = "system-refusal", "Memory, space on disk, open files or network that the system refuses."
    SIZE_EXCEEDED = (
        "size-exceeded",
        "More rows, entries, bytes or levels than stiffcal reads; the limit has a variable.",
    )
    CLUSTER_UNREACHABLE = "cluster-unreachable", "A scheduler of a cluster that does not answer or has no workers."
    PROCESS_LOST = "process-lost", "A process of a batch that ended in the middle of a campaign."
    INTERNAL_FAULT = "internal-fault", "A fault of stiffcal itself; nothing is wrong with the input."
    MORE_FAULTS = "more-faults", "The number of further faults that are not listed."

    # Files.
    FILE_MISSING = "file-missing", "A file or folder that is named and does not exist."
    FILE_UNREADABLE = "file-unreadable", "A file that exists and that the system does not let stiffcal read."
    FILE_UNWRITABLE = "file-unwritable", "A file or folder that cannot be written."
    FILE_EXISTS = "file-exists", "A file or folder that would be overwritten."
    FILE_KIND = "file-kind", "A folder, a device or a broken link in place of a file, or a file in place of a folder."
    FILE_OUTSIDE = "file-outside", "A file that lies outside the campaign folder."
    FILE_CHANGED = "file-changed", "A file or table that changed while it was read."
    FILE_EMPTY = "file-empty", "A file, table or topic without rows."
    FILE_INCOMPLETE = "file-incomplete", "A log that was cut off: its writing or its copying was interrupted."
    FILE_DAMAGED = "file-damaged", "A file whose content contradicts its own format."
    FORMAT_UNKNOWN = "format-unknown", "A format of a file that is not known or cannot be derived from the file."
    CONTENT_UNSUPPORTED = "content-unsupported", "Content of a known format that stiffcal does not read."
    ENCODING_WRONG = "encoding-wrong", "Bytes that are not text in the encoding that is set."
    SYNTAX_INVALID = "syntax-invalid", "Text that does not follow the grammar of TOML, XML, JSON or CSV."

    # Tables and logs.
    LOG_PART_MISSING = "log-part-missing", "A group, dataset, variable, topic or frame that the log does not hold."
    LOG_PART_AMBIGUOUS = "log-part-ambiguous", "Several groups, variables or topics of a log, and none is named."
    HEADER_MISSING = "header-missing", "A table without a line of column names."
    COLUMN_MISSING = "column-missing", "A column that is needed or named and that the table does not hold."
    COLUMN_DUPLICATE = "column-duplicate", "Several columns of one name."
    COLUMN_AMBIGUOUS = "column-ambiguous", "A column whose name and unit leave open what it holds."
    COLUMN_TYPE = "column-type", "A column of words where numbers are needed, or of numbers where words are needed."
    CELL_EMPTY = "cell-empty", "A cell without a value."
    NUMBER_INVALID = "number-invalid", "Text that is not a number, or a number that is not finite or implausibly large."
    SHAPE_MISMATCH = "shape-mismatch", "Numbers of rows, cells, columns or states that belong together and differ."
    ROW_UNKNOWN = "row-unknown", "A data row that is named and that the table does not hold."

    # What a person writes: manifest, robot, model.
    KEY_UNKNOWN = "key-unknown", "A key that the table of a TOML file does not have."
    KEY_MISSING = "key-missing", "A key that is needed and not written."
    KEY_CONFLICT = "key-conflict", "Keys that exclude each other, or that say two different things."
    VALUE_INVALID = "value-invalid", "A value of the wrong type, out of range, or not one of the choices."
    NAME_INVALID = "name-invalid", "A name that is empty, reserved, too long or holds characters that are refused."
    NAME_DUPLICATE = "name-duplicate", "Two things of one name."
    UNIT_UNKNOWN = "unit-unknown", "A unit that is not known, or that is of another quantity."
    UNIT_CONFLICT = "unit-conflict", "Units of columns that belong together and differ."
    FRAME_UNKNOWN = "frame-unknown", "A frame or body that is not described."
    FRAME_UNSUITABLE = "frame-unsuitable", "A frame that moves, is estimated, or refers to itself where that cannot be."
    JOINT_UNKNOWN = "joint-unknown", "A joint that the robot does not have."
    JOINT_COUNT = "joint-count", "A number of columns or angles that is not the number of the robot's joints."
    LINK_UNKNOWN = "link-unknown", "A link that the robot does not have."
    RUN_UNKNOWN = "run-unknown", "A run that is not listed."
    SOURCE_UNKNOWN = "source-unknown", "A source or a signal that is not described."
    SIGNAL_MISSING = "signal-missing", "A signal that this kind of experiment needs and that is not logged."
    URDF_INVALID = "urdf-invalid", "A URDF whose links and joints do not make the robot that is described."
    URDF_LOOP = "urdf-loop", "A URDF whose chain from base to tip is part of a closed loop: no serial arm."
    EFFECT_UNKNOWN = "effect-unknown", "An effect that is not in the catalogue."
    EFFECT_ABSENT = "effect-absent", "An effect that the model does not hold."
    HIDDEN_INACTIVE = "hidden-inactive", "A hidden effect that changes nothing in the simulated runs."
    EFFECT_CONFLICT = "effect-conflict", "Effects that cannot be in one model at one place."
    PLACE_INVALID = "place-invalid", "A place at which an effect cannot sit, or no place where one is needed."
    PARAMETER_UNKNOWN = "parameter-unknown", "A parameter that the model does not have."

    # What was measured.
    TIME_AMBIGUOUS = "time-ambiguous", "Dates whose day and month can be read in two ways."
    TIME_ORDER = "time-order", "Times that stand still, run backwards or jump."
    CLOCK_UNKNOWN = "clock-unknown", "Logs whose clocks cannot be brought together."
    READING_IMPLAUSIBLE = "reading-implausible", "A reading that no instrument of this kind gives on a robot."
    UNIT_IMPLAUSIBLE = "unit-implausible", "Readings that point to another unit than the one that is written."
    STATES_MISSING = "states-missing", "Logs in which no load state is found."
    REFERENCE_INVALID = "reference-invalid", "A state that cannot be the reference of its run."
    POSES_TOO_FEW = "poses-too-few", "Fewer different poses than an estimated frame needs."
    REGISTRATION_IMPOSSIBLE = "registration-impossible", "A frame that the unloaded poses do not determine."
    KINEMATICS_MISMATCH = "kinematics-mismatch", "Measured poses that the kinematics of the robot does not meet."
    WRENCH_MISMATCH = "wrench-mismatch", "Forces and deflections that contradict each other."
    WRENCH_REZEROED = "wrench-rezeroed", "A force sensor that was zeroed in the middle of a run."
    WRENCH_DRIFTED = "wrench-drifted", "A force sensor whose zero drifted within a run."
    MOTION_WRONG = "motion-wrong", "A joint that did not move where it should have, or moved where it should not."
    POSE_UNREACHABLE = "pose-unreachable", "A pose beyond the reach or the limits of the joints."
    PATH_INVALID = "path-invalid", "A path of poses or loads that the command cannot follow."
    DATA_MISSING = "data-missing", "Something that was asked for and was not measured in this campaign."

    # What is computed.
    NO_BALANCE = "no-balance", "A robot without equilibrium under a load: too soft, too heavy, or a wrong unit."
    NO_CONVERGENCE = "no-convergence", "An iteration that does not settle."
    MODEL_UNSUITABLE = "model-unsuitable", "A model that lacks, or holds, effects that the command cannot do with."
    MODEL_MISMATCH = "model-mismatch", "Models of two campaigns, or a model and its fit, that do not agree."
    ROBOT_MISMATCH = "robot-mismatch", "Two campaigns that are not of one robot."
    SIMULATION_UNSUPPORTED = "simulation-unsupported", "A signal, format or effect that cannot be simulated."

    # The store.
    STORE_MISSING = "store-missing", "A store, or a part of one, that was not written yet."
    STORE_OUTDATED = "store-outdated", "A step that would have to run first, and was not allowed to."
    STORE_DAMAGED = "store-damaged", "A part of the store that is not what was written."
    STORE_NEWER = "store-newer", "A store that was written by a newer stiffcal."
    STORE_LOCKED = "store-locked", "A store that another process is writing to."
    STORE_ADDRESS = "store-address", "An address of a store that cannot be used."
    STORE_INACCESSIBLE = "store-inaccessible", "A store that cannot be read, written or reached."

    # Trust.
    PLUGIN_UNTRUSTED = "plugin-untrusted", "Code of a campaign that the user has not allowed."
    PLUGIN_INVALID = "plugin-invalid", "Code of a campaign that does not do what an effect has to do."
    PLUGIN_FAILED = "plugin-failed", "Code of a campaign that raised an exception or ended the program."
    QUERY_UNTRUSTED = "query-untrusted", "A database query that the user has not allowed."
    DATABASE_UNTRUSTED = "database-untrusted", "A database, or a variable with its address, that is not allowed."
    DATABASE_ADDRESS = "database-address", "An address of a database that is absent or is none."
    DATABASE_UNREACHABLE = "database-unreachable", "A database that does not answer, or refuses what is asked."
    CONTENT_UNTRUSTED = "content-untrusted", "Results that somebody else computed, where only one's own will do."
    TRUST_RECORD = "trust-record", "The record of what the user has allowed cannot be written."
