"""Images as floats, by way of `tyndall convert` to KTX2."""
import array, struct, subprocess


def read_floats(tyndall, path):
    """Width, height, and four floats a pixel, rows from the top."""
    subprocess.run([tyndall, "convert", path, "floats.ktx2", "--texels", "float", "--no-zstd", "-q"], check=True)
    data = open("floats.ktx2", "rb").read()
    width, height = struct.unpack_from("<2I", data, 20)
    at, = struct.unpack_from("<Q", data, 80)
    return width, height, array.array("f", data[at:at + 16 * width * height])
