"""Each command's own options, for the completion script: listed here, so that printing it imports no command."""

WITH_EVERY_COMMAND = "--debug --force --help --json --log-file --overwrite --verbose"
OPTIONS = {
    "init": "--from --kind --robot --tool --urdf",
    "check": "--details --quick --run --store",
    "ingest": "--store",
    "identify": "--coupling --details --dual-quaternions --loss --no-update --store",
    "validate": "--details --model --no-update --store --thresholds",
    "diagnose": "--details --jobs --no-update --store",
    "improve": "--dry-run --likely --no-report --no-update --report --store --yes",
    "compare": "--details --no-update",
    "trend": "--details --max-change --no-update --output",
    "history": "--restore --store --yes",
    "plot": "--against --no-update --of --output --run --store",
    "report": "--no-update --output --short --store",
    "view": "--live --no-raw --no-update --open --output --store --watch",
    "run": "--store",
    "batch": "--idle-timeout --jobs --junit --markdown --no-report --reports --scheduler --store --thresholds",
    "export": (
        "--convention --cycle-ms --filter --leave-out --no-update --output --raw-text --sensor --store --strict "
        "--target --tool --zeroed-at"
    ),
    "predict": "--at --details --force --load-path --no-update --note --output --points --pose --poses --store",
    "map": (
        "--at --load --mass --no-update --output --plane --points --pose --slices --stiffness --store --table --target"
    ),
    "compensate": (
        "--acts-on --filter --frame --judge --log --never-zeroed --no-sag --no-update --normal --output --path "
        "--picture --position-only --sag --segments --start --store --target --tool --zeroed"
    ),
    "plan": "--campaign --criterion --details --for --no-update --output --program --runs --store --tell",
    "simulate": "--from --seed",
    "effects": "--from --output",
    "add": "--all --curved --joints --links --pairs --start",
    "remove": "--all --joints --links --pairs",
    "trust": "--edit --hash --list --revoke --store --yes",
    "demo": "",
    "doctor": "",
}
