"""Whether every link within a folder of HTML leads somewhere.

links.py SITE: files that are not there, anchors that their page has not.
"""
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    """The links of a page, and the anchors that it has."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src", "data") and value:
                self.links.append(value)


def main():
    site = pathlib.Path(sys.argv[1]).resolve()
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    faults, seen, outside = [], 0, 0
    for path, page in pages.items():
        where = path.relative_to(site)
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                outside += 1
                continue
            seen += 1
            target = path
            if parts.path:
                target = (path.parent / urllib.parse.unquote(parts.path))
                target = target.resolve()
                if target.is_dir():
                    target /= "index.html"
            if not target.is_file() or site not in target.parents:
                faults.append(f"{where}: {link} leads nowhere")
            elif parts.fragment and target in pages and urllib.parse.unquote(
                    parts.fragment) not in pages[target].anchors:
                faults.append(f"{where}: {link} has no such anchor")
    print(f"site: {len(pages)} pages, {seen} links within, {outside} to other "
          "sites")
    for fault in faults:
        print(fault, file=sys.stderr)
    sys.exit(bool(faults) or len(pages) < 2)


if __name__ == "__main__":
    main()
