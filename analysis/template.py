"""Templates of the pages: what is filled in is escaped, and a name that nobody filled in is an error."""

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined, Template


def template(*packages: str) -> Template:
    """The page.html of the first of these packages; what it includes may lie in any of them."""
    loader = ChoiceLoader([PackageLoader(package, ".") for package in packages])
    options = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return options.get_template("page.html")
