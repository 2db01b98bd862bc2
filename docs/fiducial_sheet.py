"""A sheet of fiducial strips to print at 100 % and cut out: fiducial_sheet.py FILE.pdf [DIAMETER_MM PITCH_MM]...

A page of A4 for each diameter and pitch: upright strips of dark discs, with a mark beside each centre to lay a ruler at,
and two rulers of 100 mm that tell whether the printer kept the scale.
"""

import sys

import cairo

MM = 72 / 25.4  # points
WIDTH, HEIGHT, MARGIN = 210, 297, 12  # mm
RULER = 100  # mm


def line(page, *points, width=0.2):
    page.move_to(*points[0])
    for point in points[1:]:
        page.line_to(*point)
    page.set_line_width(width)
    page.stroke()


def text(page, x, y, words, size=3.5):
    page.set_font_size(size)
    page.move_to(x, y)
    page.show_text(words)


def ruler(page, x, y, along):
    """100 mm from (x, y) along the unit vector, a tick every 10 mm."""
    across = (along[1], -along[0])
    line(page, (x, y), (x + RULER * along[0], y + RULER * along[1]))
    for mm in range(0, RULER + 1, 10):
        tick = 4 if mm % 50 == 0 else 2.5
        start = (x + mm * along[0], y + mm * along[1])
        line(page, start, (start[0] + tick * across[0], start[1] + tick * across[1]))


def strip(page, left, top, width, discs, diameter, pitch):
    """A strip to cut out; returns the height of its lower edge."""
    bottom = top + discs * pitch
    page.set_dash([2, 2])
    line(page, (left, top), (left + width, top), (left + width, bottom), (left, bottom), (left, top))
    page.set_dash([])
    for disc in range(discs):
        x, y = left + width / 2, top + (disc + 0.5) * pitch
        page.arc(x, y, diameter / 2, 0, 6.283185307179586)
        page.fill()
        for edge, inwards in ((left, 1), (left + width, -1)):
            line(page, (edge, y), (edge + 3 * inwards, y))
    for edge, inwards in ((top, 1), (bottom, -1)):
        line(page, (left + width / 2, edge), (left + width / 2, edge + 3 * inwards))
    return bottom


def sheet(page, diameter, pitch):
    page.scale(MM, MM)
    page.select_font_face("sans-serif")
    text(page, MARGIN, 17, f"Graintruth: fiducials of {diameter:g} mm, centres {pitch:g} mm apart", 5)
    text(page, MARGIN, 24, "Print at 100 %, matt. Both rulers must measure 100.0 mm; if not, measure the pitch and use that.")
    text(page, MARGIN, 29.5, "Cut along the dashed lines. Mount flat, in the plane of the particles' centres, all around the picture.")
    text(page, MARGIN, 35, "Lay a ruler from your origin to the marks beside the centres:")
    text(page, MARGIN, 40.5, f"fiducial_diameter_mm = {diameter:g}    fiducials_mm = [[x, z], [x, z + {pitch:g}], ...]")
    ruler(page, MARGIN, 54, (1, 0))
    ruler(page, WIDTH - MARGIN, 62, (0, 1))

    width, top = max(2 * diameter, 22), 62
    discs = int((HEIGHT - MARGIN - top) // pitch)
    left = MARGIN
    while left + width <= WIDTH - 2 * MARGIN:
        strip(page, left, top, width, discs, diameter, pitch)
        left += width + 4


def main(file, *sizes):
    sizes = [float(size) for size in sizes] or [8, 30, 14, 40]
    surface = cairo.PDFSurface(file, WIDTH * MM, HEIGHT * MM)
    surface.set_metadata(cairo.PDF_METADATA_TITLE, "Graintruth: fiducials")
    for diameter, pitch in zip(sizes[::2], sizes[1::2]):
        sheet(cairo.Context(surface), diameter, pitch)
        surface.show_page()
    surface.finish()


if __name__ == "__main__":
    if len(sys.argv) < 2 or len(sys.argv) % 2:
        sys.exit(__doc__)
    main(*sys.argv[1:])
