"""What every section of a spec is: its keys are known, its values cannot be changed."""

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """A section."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
