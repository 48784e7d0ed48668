#!/usr/bin/env python3
"""links.py FOLDER: of the pages in FOLDER every link to a file of the site leads to one, and to a place in it that is there; nothing is
loaded from elsewhere; no list or table was left as text."""
import html.parser
import os
import re
import sys
import urllib.parse

folder = os.path.abspath(sys.argv[1])
failures = []


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.places, self.loaded, self.text, self.inside = [], set(), [], [], []
        with open(path, encoding="utf-8") as f:
            self.feed(f.read())

    def handle_starttag(self, tag, attrs):
        of = dict(attrs)
        self.places.update(v for v in (of.get("id"), of.get("name") if tag == "a" else None) if v)
        if tag in ("a", "area") and of.get("href"):
            self.links.append(of["href"])
        for key in ("src", "href") if tag in ("script", "img", "link", "iframe") else ():
            if of.get(key) and of.get("rel") != "canonical":
                self.loaded.append(of[key])
        if tag in ("p", "pre", "code", "script", "style"):
            self.inside.append(tag)

    def handle_endtag(self, tag):
        if tag in self.inside:
            while self.inside.pop() != tag:
                pass

    def handle_data(self, data):
        if self.inside == ["p"]:
            self.text.append(data)


def is_elsewhere(link):
    return urllib.parse.urlsplit(link).scheme not in ("", "data") or link.startswith("//")


def main():
    pages = {}
    for at, _, names in os.walk(folder):
        for name in names:
            # the reference of the headers and a page of the program are not made of Markdown
            if name.endswith(".html"):
                pages[os.path.join(at, name)] = Page(os.path.join(at, name))
    seen = 0
    for path, page in pages.items():
        name = os.path.relpath(path, folder)
        if name.startswith("api" + os.sep):
            continue
        failures.extend(f"{name} loads {one}" for one in page.loaded if is_elsewhere(one))
        for text in "".join(page.text).splitlines():
            if re.match(r"\s*([-*] |\|.*\|\s*$|\d+\. )", text):
                failures.append(f"{name}: left as text: {text[:70]}")
        for link in page.links:
            if is_elsewhere(link) or link.startswith("data:"):
                continue
            seen += 1
            parts = urllib.parse.urlsplit(link)
            target = os.path.normpath(os.path.join(os.path.dirname(path), urllib.parse.unquote(parts.path))) if parts.path else path
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            if not os.path.exists(target):
                failures.append(f"{name}: {link} leads nowhere")
            elif parts.fragment and target in pages and urllib.parse.unquote(parts.fragment) not in pages[target].places and parts.fragment != "__skip":
                failures.append(f"{name}: {link}: no such place")
    print("\n".join(sorted(set(failures))))
    print(f"{len(pages)} pages, {seen} links, {len(set(failures))} failures")
    return bool(failures) or len(pages) < 40 or seen < 500


sys.exit(main())
