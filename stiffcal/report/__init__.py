"""The report package: pages (typst) and figures (matplotlib) that draw what the other packages found.

`content.ReportContent` is what goes in, `building.build_report` makes the PDF, `figures` holds one picture per file.
matplotlib and typst are loaded only when something is drawn.
"""
