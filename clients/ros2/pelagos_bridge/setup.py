from setuptools import setup

NAME = "pelagos_bridge"

setup(
    name=NAME,
    version="0.2.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/bridge.launch.py"]),
        (f"share/{NAME}/config", ["config/bridge.yaml"]),
    ],
    python_requires=">=3.10",
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="Pelagos",
    maintainer_email="pelagos@example.org",
    description="Pelagos as topics and services",
    license="MIT",
    entry_points={"console_scripts": [f"bridge = {NAME}.node:main"]},
)
