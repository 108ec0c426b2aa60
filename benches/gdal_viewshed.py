#!/usr/bin/env python3
"""Compares skyshed with GDAL's gdal_viewshed: time, memory and wrong cells, on the same rasters, in one run.

    cargo build --release
    python3 benches/gdal_viewshed.py --sizes 1024,2048
    python3 benches/gdal_viewshed.py --library site-packages/pyogrio.libs/libgdal-*.so.*

Generated cities become uncompressed float32 surface models without tiles. A UAV hovers over a street cell in their middle
and receivers stand on the surface, since that is all that a viewshed knows; both programs then mean the same heights.
Every program runs once unmeasured, so that its input is in the cache, then --repeat times, the programs taking turns and
each time into a new file. User and system time and peak memory are those of each process alone, as the kernel reports them
(wait4). Masks are compared cell by cell with that of skyshed's exact rays, which the tests compare with rational arithmetic.

The report is Markdown on standard output; progress goes to standard error. Needs Python 3.10 or later without packages,
gdal-bin (gdal_viewshed, gdal_translate, gdalinfo) and a release build of skyshed.
"""

import argparse
import array
import ctypes
import json
import os
import platform
import resource
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

GDAL_PROGRAMS = ("gdal_viewshed", "gdal_translate", "gdalinfo")
ENVIRONMENTS = "suburban,urban,dense-urban,high-rise"
RX_HEIGHT_M = 1.5
CHUNK = 1 << 24
"""Bytes of a mask that are compared at once."""


class Failure(Exception):
    """What went wrong, in words for whoever runs this."""


def say(text):
    print(text, file=sys.stderr, flush=True)


def main():
    args = arguments()
    if args.viewshed:
        viewshed(*args.viewshed)
        return 0
    if args.compare:
        print(json.dumps(compare(*args.compare)))
        return 0
    scratch = None
    try:
        check_programs(args)
        scratch = Path(tempfile.mkdtemp(prefix="gdal_viewshed-", dir=args.scratch))
        cases = [Case(args, scratch, name, size) for size in args.sizes for name in args.environments]
        reports = [case.run() for case in cases]
        print(report(args, reports))
        return 0
    except Failure as failure:
        say(f"error: {failure}")
        return 1
    finally:
        if scratch is not None and args.keep:
            say(f"kept {scratch}")
        elif scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)


def arguments():
    def numbers(text):
        try:
            values = [int(word) for word in text.split(",")]
        except ValueError:
            raise argparse.ArgumentTypeError(f"`{text}`: wanted whole numbers, separated by commas") from None
        if min(values) < 1:
            raise argparse.ArgumentTypeError(f"`{text}`: wanted numbers above 0")
        return values

    def words(text):
        return [word for word in text.split(",") if word]

    default = Path(__file__).resolve().parent.parent / "target" / "release" / "skyshed"
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", 1)[0], epilog="See the top of the file.")
    add = parser.add_argument
    add("--sizes", type=numbers, default=[4096], metavar="N,N", help="edge lengths of the cities [cells of 1 m]; 4096")
    add("--environments", type=words, default=words(ENVIRONMENTS), metavar="NAMES", help=f"of ITU cities; {ENVIRONMENTS}")
    add("--methods", type=words, default=["auto"], metavar="NAMES", help="of `skyshed map --method`; auto")
    add("--threads", type=numbers, default=[1, 2], metavar="N,N", help="threads of skyshed, one row each; 1,2")
    add("--height", type=float, default=100.0, metavar="M", help="height of the UAV above the street [m]; 100")
    add("--repeat", type=int, default=3, metavar="N", help="measured runs of each program, of which medians are given; 3")
    add("--seed", type=int, default=1, metavar="N", help="seed of the cities; 1")
    add("--no-truth", action="store_true", help="do not compute exact rays: slow on large cities; no wrong cells then")
    add("--no-gdal", action="store_true", help="measure skyshed alone")
    add("--library", type=Path, metavar="FILE", help="libgdal of another version, measured with the start of Python")
    add("--skyshed", type=Path, default=default, metavar="FILE", help="the program; target/release/skyshed")
    add("--scratch", type=Path, metavar="FOLDER", help="where files go meanwhile; the system's folder for such")
    add("--keep", action="store_true", help="keep those files")
    add("--viewshed", nargs=6, help=argparse.SUPPRESS)
    add("--compare", nargs=2, metavar=("MASK", "TRUTH"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.repeat < 1:
        parser.error("--repeat: wanted at least 1")
    return args


def check_programs(args):
    missing = [name for name in GDAL_PROGRAMS if shutil.which(name) is None]
    if missing:
        raise Failure(f"cannot find {', '.join(missing)}; on Debian and Ubuntu: apt-get install gdal-bin")
    if not args.skyshed.is_file():
        raise Failure(f"cannot find {args.skyshed}; cargo build --release makes it, --skyshed names another")
    if args.library is not None and not args.library.is_file():
        raise Failure(f"cannot find {args.library}; the wheel of pyogrio has one in its folder pyogrio.libs")
    if args.scratch is not None and not args.scratch.is_dir():
        raise Failure(f"--scratch {args.scratch} is no folder")


def clean_environment():
    """The environment without settings that change how GDAL works."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("GDAL_", "VSI_", "RAYON_"))}
    return {**kept, "LC_ALL": "C"}


def call(words):
    """Runs a program that is not measured and returns its standard output."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=clean_environment())
    if done.returncode != 0:
        raise Failure(f"{shlex.join(map(str, words))} ended with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def measure(words):
    """Runs a program and returns CPU seconds, wall seconds and peak memory [MB] of that process."""
    # What a child inherits counts as its memory until it becomes the program, so this process must stay small: masks are
    # read by a process of their own.
    with tempfile.TemporaryFile() as messages:
        start = time.perf_counter()
        child = subprocess.Popen(
            [str(word) for word in words], stdout=subprocess.DEVNULL, stderr=messages, env=clean_environment()
        )
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            messages.seek(0)
            said = messages.read().decode(errors="replace").strip()
            raise Failure(f"{shlex.join(map(str, words))} ended with {child.returncode}: {said}")
    return {"user": usage.ru_utime, "system": usage.ru_stime, "wall": wall, "peak": peak_mb(usage)}


def remove(mask):
    """Removes a mask and what describes it, so that making a file is measured and not freeing the one before."""
    for path in mask.parent.glob(mask.name + "*"):
        path.unlink()


def peak_mb(usage):
    # Linux counts in KiB, macOS in bytes.
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6


class Case:
    """One city and all programs on it."""

    def __init__(self, args, scratch, environment, size):
        self.args = args
        self.environment = environment
        self.size = size
        self.folder = scratch / f"{environment}-{size}"
        self.dsm = self.folder / "dsm.tif"

    def run(self):
        name = f"{self.environment} {self.size}²"
        say(f"{name}: making the city")
        self.folder.mkdir()
        try:
            preparation = self.make_city()
            x, y = self.street_in_the_middle()
            programs = self.programs(x, y)
            runs = {label: [] for label, _, _ in programs}
            for turn in range(self.args.repeat + 1):
                say(f"{name}: " + (f"run {turn} of {self.args.repeat}" if turn else "warming up"))
                for label, words, mask in programs:
                    remove(mask)
                    found = measure(words)
                    if turn:
                        runs[label].append(found)
            truth = None
            truth_command = None
            if not self.args.no_truth:
                say(f"{name}: exact rays, for comparison")
                truth = self.folder / "truth.tif"
                truth_command = self.skyshed(x, y, truth, ["--method", "ray", "--tif-layout", "plain"])
                call(truth_command)
                truth = self.pixels(truth)
            rows = []
            for label, _, mask in programs:
                counts = self.counts(self.pixels(mask), truth)
                medians = {key: statistics.median(run[key] for run in runs[label]) for key in runs[label][0]}
                rows.append({"label": label, "runs": runs[label], **medians, **counts})
            commands = preparation + [words for _, words, _ in programs] + ([truth_command] if truth_command else [])
            return {
                "environment": self.environment,
                "size": self.size,
                "rows": rows,
                "commands": [self.written(words) for words in commands],
            }
        finally:
            if not self.args.keep:
                shutil.rmtree(self.folder, ignore_errors=True)

    def make_city(self):
        city = self.folder / "city.tif"
        words = [self.args.skyshed, "city", f"itu:{self.environment}", "--size", self.size, "--seed", self.args.seed]
        make = words + ["-o", city, "-q"]
        convert = ["gdal_translate", "-q", "-ot", "Float32", "-a_nodata", "none", "-co", "COMPRESS=NONE"]
        convert += ["-co", "TILED=NO", "-co", "BIGTIFF=IF_NEEDED", city, self.dsm]
        for words in (make, convert):
            call(words)
        city.unlink()
        return [make, convert]

    def street_in_the_middle(self):
        """The center of the street cell nearest to the middle of the city."""
        facts = json.loads(call(["gdalinfo", "-json", self.dsm]))
        x_min, cell_width, _, y_max, _, cell_height = facts["geoTransform"]
        edge = min(self.size, 401)
        first = (self.size - edge) // 2
        window = self.folder / "window"
        call(["gdal_translate", "-q", "-of", "ENVI", "-srcwin", first, first, edge, edge, self.dsm, window])
        heights = array.array("f")
        heights.frombytes(window.read_bytes())
        if sys.byteorder == "big":
            heights.byteswap()

        def from_middle(cell):
            return abs(cell // edge - edge // 2) + abs(cell % edge - edge // 2)

        streets = [cell for cell, height in enumerate(heights) if height == 0.0]
        if not streets:
            raise Failure(f"{self.environment}, {self.size} cells: no street cell near the middle")
        row, col = divmod(min(streets, key=from_middle), edge)
        return x_min + (first + col + 0.5) * cell_width, y_max + (first + row + 0.5) * cell_height

    def skyshed(self, x, y, mask, options):
        uav = f"{x},{y},{self.args.height:g}"
        words = [self.args.skyshed, "map", self.dsm, "--uav", uav, "--rx-height", RX_HEIGHT_M]
        return words + options + ["-o", mask, "--overwrite", "-q"]

    def programs(self, x, y):
        """Label, command line and mask of each program."""
        found = []
        if not self.args.no_gdal:
            mask = self.folder / "gdal.tif"
            words = ["gdal_viewshed", "-q", "-md", "0", "-cc", "0", "-oz", f"{self.args.height:g}", "-tz", RX_HEIGHT_M]
            words += ["-ox", x, "-oy", y, "-vv", "1", "-iv", "0", "-ov", "0", "-co", "COMPRESS=NONE", self.dsm, mask]
            found.append(("gdal_viewshed", words, mask))
        if self.args.library is not None:
            mask = self.folder / "library.tif"
            words = [sys.executable, __file__, "--viewshed", self.args.library, self.dsm, mask, x, y, self.args.height]
            found.append((f"GDAL {gdal_version(ctypes.CDLL(self.args.library))}", words, mask))
        for method in self.args.methods:
            for threads in self.args.threads:
                mask = self.folder / f"{method.replace(':', '-')}-{threads}.tif"
                options = ["--method", method, "-j", threads, "--tif-layout", "plain"]
                found.append((f"skyshed {method}, -j {threads}", self.skyshed(x, y, mask, options), mask))
            threads = max(self.args.threads)
            mask = self.folder / f"{method.replace(':', '-')}-cog.tif"
            options = ["--method", method, "-j", threads]
            label = f"skyshed {method}, -j {threads}, default output"
            found.append((label, self.skyshed(x, y, mask, options), mask))
        return found

    def pixels(self, tif):
        """The cells of a mask as a file of bare bytes."""
        raw = tif.with_suffix(".raw")
        call(["gdal_translate", "-q", "-of", "ENVI", "-ot", "Byte", tif, raw])
        tif.unlink()
        if raw.stat().st_size != self.size**2:
            raise Failure(f"{tif.name} has {raw.stat().st_size} cells, wanted {self.size}²")
        return raw

    def counts(self, mask, truth):
        return json.loads(call([sys.executable, __file__, "--compare", mask, truth or ""]))

    def written(self, words):
        """A command as one would type it in the folder of the repository, with files in `$S`."""
        text = shlex.join(str(word) for word in words)
        text = text.replace(str(self.folder) + os.sep, "$S/")
        return text.replace(str(self.args.skyshed), "skyshed")


def gdal_version(gdal):
    gdal.GDALVersionInfo.restype = ctypes.c_char_p
    return gdal.GDALVersionInfo(b"RELEASE_NAME").decode()


def viewshed(library, dsm, mask, x, y, height):
    """Makes a viewshed with a GDAL library, as gdal_viewshed does with the options above."""
    gdal = ctypes.CDLL(library)
    text, number, pointer = ctypes.c_char_p, ctypes.c_double, ctypes.c_void_p
    gdal.GDALAllRegister()
    gdal.GDALOpen.restype = gdal.GDALGetRasterBand.restype = gdal.GDALViewshedGenerate.restype = pointer
    gdal.GDALOpen.argtypes = [text, ctypes.c_int]
    gdal.GDALGetRasterBand.argtypes = [pointer, ctypes.c_int]
    gdal.GDALClose.argtypes = [pointer]
    # Position and heights; visible, invisible, out of range and nodata; curvature. Then mode, range and kind of output.
    gdal.GDALViewshedGenerate.argtypes = [pointer, text, text, pointer] + 9 * [number]
    gdal.GDALViewshedGenerate.argtypes += [ctypes.c_int, number, pointer, pointer, ctypes.c_int, pointer]
    source = gdal.GDALOpen(dsm.encode(), 0)
    options = (text * 2)(b"COMPRESS=NONE", None)
    place = [float(x), float(y), float(height), RX_HEIGHT_M]
    edge, normal = 2, 1
    band = gdal.GDALGetRasterBand(source, 1)
    rules = [1, 0, 0, -1, 0, edge, 0, None, None, normal, None]
    made = gdal.GDALViewshedGenerate(band, b"GTiff", mask.encode(), options, *place, *rules)
    if not made:
        raise SystemExit("GDAL made no viewshed")
    gdal.GDALClose(made)
    gdal.GDALClose(source)


def compare(mask, truth):
    """Counts of a mask of 0 (NLoS) and 1 (LoS), and of the cells in which it differs from the truth, if there is one."""
    counts = {"receivers": 0, "los": 0}
    if truth:
        counts.update(truth_los=0, false_los=0, missed_los=0)
    with open(mask, "rb") as found, open(truth or os.devnull, "rb") as wanted:
        while chunk := found.read(CHUNK):
            a = bits(chunk, mask)
            counts["receivers"] += len(chunk)
            counts["los"] += a.bit_count()
            if truth:
                b = bits(wanted.read(CHUNK), truth)
                counts["truth_los"] += b.bit_count()
                counts["false_los"] += (a & (a ^ b)).bit_count()
                counts["missed_los"] += (b & (a ^ b)).bit_count()
    return counts


def bits(chunk, name):
    """Bytes of 0 and 1 as one long integer, whose set bits can be counted at once."""
    if chunk.translate(None, b"\x00\x01"):
        raise SystemExit(f"error: {name} holds values other than 0 and 1")
    return int.from_bytes(chunk, "little")


def report(args, cases):
    lines = [
        "| city | cells | program | CPU [ns per cell] | user + system [s] | wall [s] | peak [MB] | wrong cells "
        "| false LoS | missed LoS | P_LoS |",
        "|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for case in cases:
        for row in case["rows"]:
            cells = case["size"] ** 2
            cpu = statistics.median(run["user"] + run["system"] for run in row["runs"])
            wrong = false_los = missed = "–"
            if "truth_los" in row:
                n_wrong = row["false_los"] + row["missed_los"]
                wrong = f"{n_wrong} ({percent(n_wrong, row['receivers'])} of receivers)" if n_wrong else "0"
                false_los = str(row["false_los"])
                missed = f"{row['missed_los']} ({percent(row['missed_los'], row['truth_los'])} of LoS)"
                missed = missed if row["missed_los"] else "0"
            fields = [
                case["environment"],
                f"{case['size']}²",
                row["label"],
                f"{cpu / cells * 1e9:.1f}",
                f"{row['user']:.2f} + {row['system']:.2f}",
                f"{row['wall']:.2f}",
                f"{row['peak']:.0f}",
                wrong,
                false_los,
                missed,
                f"{row['los'] / row['receivers']:.4f}",
            ]
            lines.append("| " + " | ".join(fields) + " |")
    lines += [
        "",
        f"UAV {args.height:g} m above a street cell in the middle, receivers {RX_HEIGHT_M} m above the surface, all cells "
        f"are receivers. Medians over {args.repeat} run{'s' * (args.repeat > 1)}, cache warm, programs taking turns, new files. "
        "Wrong cells, false and missed "
        + ("LoS were not counted (--no-truth)." if args.no_truth else "LoS: against `skyshed map --method ray`."),
        "",
    ]
    lines += [f"* {fact}" for fact in machine(args)]
    lines += ["", "Commands, with `$S` the scratch folder of a city:", "", "```sh"]
    for case in cases:
        lines += [f"# {case['environment']}, {case['size']}²", *case["commands"]]
    lines.append("```")
    return "\n".join(lines)


def percent(part, whole):
    return f"{100.0 * part / whole:.2f} %" if whole else "–"


def machine(args):
    model = platform.processor() or platform.machine()
    memory = ""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
        kib = int(Path("/proc/meminfo").read_text().split("MemTotal:")[1].split()[0])
        memory = f", {kib / 2**20:.0f} GiB"
    except (OSError, IndexError, ValueError):
        pass
    load = f", load {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    return [
        f"{model}, {os.cpu_count()} cores{memory}{load}; {platform.system()} {platform.release()}",
        f"{call([args.skyshed, '--version']).strip()}; {call(['gdalinfo', '--version']).strip()}; "
        f"Python {platform.python_version()}; {time.strftime('%Y-%m-%d')}",
        f"peaks below {peak_mb(resource.getrusage(resource.RUSAGE_SELF)):.0f} MB are those of this script, from which the "
        "programs are started",
    ]


if __name__ == "__main__":
    sys.exit(main())
