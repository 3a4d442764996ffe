extends "demo_scene.gd"
## A hundred volumes of two scans, turned, stretched and overlapping, on a spiral.

## How many.
@export_range(1, 400) var count := 100
## Draws the turns and sizes.
@export var seed_value := 7

const LOOKS: PackedStringArray = ["ct-muscle", "ct-skin", "ct-bone", "ct-angiography"]
const GOLDEN_ANGLE := 2.399963

var _volumes: Array[LumivoxVolume3D] = []
var _head_shape := SphereMesh.new()

@onready var _crowd: Node3D = $Crowd


func _ready() -> void:
	var random := RandomNumberGenerator.new()
	random.seed = seed_value
	_head_shape.radius = 0.078
	_head_shape.height = 0.21
	for i in count:
		var node := LumivoxVolume3D.new()
		var radius := 0.15 * sqrt(i + 0.5)
		var angle := i * GOLDEN_ANGLE
		node.position = Vector3(radius * cos(angle), 0.13 + 0.10 * sin(radius * 5.0), radius * sin(angle))
		node.rotation = Vector3(random.randf_range(-0.35, 0.35), random.randf_range(-PI, PI), random.randf_range(-0.35, 0.35))
		node.scale = Vector3.ONE * random.randf_range(0.55, 1.0)
		node.scale.y *= random.randf_range(0.8, 1.25)
		_crowd.add_child(node)
		node.add_child(_shadow())
		_volumes.append(node)
	source.targets = _volumes
	source.preset = ""
	super()


## Meshes get no shadow from volumes: this casts one where a head is, and is not seen itself.
func _shadow() -> MeshInstance3D:
	var stand_in := MeshInstance3D.new()
	stand_in.mesh = _head_shape
	stand_in.position = Vector3(0.0, 0.04, 0.01)
	stand_in.cast_shadow = GeometryInstance3D.SHADOW_CASTING_SETTING_SHADOWS_ONLY
	return stand_in


## Few transfer functions for many volumes: a resource may be shared.
func _on_grown(volume: LumivoxVolume) -> void:
	for i in _volumes.size():
		_volumes[i].apply_preset(LOOKS[i % LOOKS.size()])
	super(volume)
