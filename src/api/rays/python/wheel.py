# SPDX-License-Identifier: Apache-2.0
# Packs the module `sunstone` and its libraries as a wheel. The CMake target `wheel` calls it.
import argparse
import base64
import hashlib
import pathlib
import sys
import sysconfig
import zipfile


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--version", required=True)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    given = parser.parse_args()

    tag = "cp%d%d" % sys.version_info[:2]
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    name = f"sunstone-{given.version}"
    info = f"{name}.dist-info"
    contents = {file.name: file.read_bytes() for file in given.files}
    contents[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: sunstone\nVersion: {given.version}\n"
        "Summary: Rays against triangles, on CPUs and CUDA GPUs\nLicense: Apache-2.0\n"
        "Requires-Dist: numpy\n").encode()
    contents[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: sunstone\nRoot-Is-Purelib: false\n"
        f"Tag: {tag}-{tag}-{platform}\n").encode()
    record = ""
    for path, data in contents.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(data)}\n"
    contents[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()

    given.output.mkdir(parents=True, exist_ok=True)
    wheel = given.output / f"{name}-{tag}-{tag}-{platform}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in contents.items():
            archive.writestr(path, data)
    print(wheel)


main()
