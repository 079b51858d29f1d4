"""The mathematics, one module per subject: functions in GA notation that run on symbols and on numbers."""
