// The host's depth as kernels read it: a texture of the view's own size, whatever the host's is. Written by hand.
Shader "Hidden/Lumivox/LumivoxDepthArray"
{
    SubShader
    {
        Pass
        {
            Cull Off
            ZTest Always
            ZWrite Off

HLSLPROGRAM
#pragma target 4.5
#pragma vertex fullscreen
#pragma fragment host_depth_copy_array

struct SliceParams {
    uint4 slice;
};

cbuffer params_buffer { SliceParams params; }
Texture2DArray<float4> _CameraDepthTexture;

float4 fullscreen(uint vertex : SV_VertexID) : SV_Position
{
    float2 corner = float2(float(vertex & 1u), float(vertex >> 1u));
    return float4(corner * 4.0 - 1.0, 0.0, 1.0);
}

float4 host_depth_copy_array(float4 position : SV_Position) : SV_Target0
{
    float depth = _CameraDepthTexture.Load(int4(int2(position.xy), int(params.slice.x), 0)).x;
    return float4(depth, 0.0, 0.0, 0.0);
}
ENDHLSL
        }
    }
}
